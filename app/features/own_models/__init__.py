"""Models in a user's own files: loaded, watched, and guarded against their failures."""
