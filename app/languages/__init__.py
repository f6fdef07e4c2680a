"""Languages of page, lessons and commands: English stands in the code, the rest in ``*.po``.

One file a language, in gettext's form; its English texts are the keys. ``python -m
app.languages.update`` writes new texts of the code into each file and drops old ones.
"""
