"""How much tape the camera sees: an example of a feature of BrickPose."""
