"""Fields of one's own: pictures of all, files that are kept, an editor, and sheets to print."""
