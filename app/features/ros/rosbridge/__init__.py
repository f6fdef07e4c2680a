"""The rosbridge protocol, version 2, for roslibjs, roslibpy, MATLAB and custom web pages."""
