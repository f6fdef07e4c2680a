"""The lessons, a folder each: text in each language, picture, stub, checks."""
