"""Files of lenses, as ROS, Kalibr, OpenCV, DepthAI, COLMAP, mrcal and Metashape write them."""
