"""``/help``: the documents of ``docs/`` as pages, so that they are at hand without internet."""
