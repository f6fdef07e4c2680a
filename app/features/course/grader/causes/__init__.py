"""The causes that the grader knows, in words.

M1 to E2 are mistakes that real students made, in courses elsewhere; the others have a word.
"""
