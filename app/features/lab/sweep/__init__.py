"""Sweeps: the experiment at many settings; results are kept by point, so none is done twice."""
