"""The interface for programs as one plain page, ``/docs``."""
