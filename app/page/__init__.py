"""The page's other side: HTTP, sockets, who may talk, and what is said."""
