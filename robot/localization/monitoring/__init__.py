"""Do scans and odometry fit what the models claim? If not: by how much, and why?"""
