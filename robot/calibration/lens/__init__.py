"""The lens, by pictures of a printed board."""
