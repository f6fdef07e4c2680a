"""Values handed from thread to thread: the newest, or all of them."""
