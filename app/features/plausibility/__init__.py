"""Says what cannot be true of pictures and wheels: plugs in the wrong place, a picture that stands.

A robot of which that is so never finds its place, and what it then seems to be is misleading.
"""
