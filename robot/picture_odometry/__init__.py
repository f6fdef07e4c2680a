"""Motion from the picture: how the floor moved between two pictures, and what wheels say of it."""
