"""The robot in bricks: motors and encoders on a Build HAT, and a camera."""
