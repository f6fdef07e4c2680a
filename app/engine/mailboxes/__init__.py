"""Mailboxes between threads, which pass on the newest value or all values."""
