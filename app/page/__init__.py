"""The server behind the page: HTTP, websockets, access control and messages."""
