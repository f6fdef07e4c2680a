"""Motion from the picture: a second odometer, which tests the wheels, and the floor from above."""
