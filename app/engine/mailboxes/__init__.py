"""Mailboxes between threads; none of them makes the writer wait.

``Latest`` holds one value: its readers get the newest and skip older ones, as views do.
``Backlog`` holds all values for one reader, in order; those that find no room are counted as lost.
``Broadcast`` gives each subscriber a ``Backlog`` of its own.
``Outbox`` holds a few values of each name for one slow reader, and drops the oldest.
"""
