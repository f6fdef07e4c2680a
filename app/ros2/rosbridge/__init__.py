"""The rosbridge protocol, version 2: roslibjs, roslibpy, MATLAB and pages of one's own."""
