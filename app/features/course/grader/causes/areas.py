"""Which part of a function is wrong, where its mistake is not known."""

from __future__ import annotations

from app.features.course.grader.causes.cause import Cause

AREAS = {
    "place": Cause(
        "The robot is said to be in a wrong place.",
        "The heading is right; x and y are not.",
        "Work out x and y of the case on paper, and print what they are made of.",
    ),
    "heading": Cause(
        "The robot is said to look in a wrong direction.",
        "x and y are right; the heading is not.",
        "Work out the heading of the case on paper, and print what it is made of.",
    ),
    "estimate": Cause(
        "The robot is said to be in a wrong place, and to look in a wrong direction.",
        "Neither x and y of the estimate nor its heading are right.",
        "Print which particles the estimate is made of, and with which weights.",
    ),
    "step": Cause(
        "The robot is said to be in a wrong place, and to look in a wrong direction.",
        "The step itself is wrong, its way or its turn, before any noise.",
        "Print way and turn of the case, and compare them with what was asked.",
    ),
    "range": Cause(
        "What is seen lies too near, or too far.",
        "The bearing is right; the range is not.",
        "The range is how far the point on the floor is from the axle: print x and y of it.",
    ),
    "bearing": Cause(
        "What is seen lies in a wrong direction.",
        "The range is right; the bearing is not.",
        "The bearing is arctan2(y, x) of the point on the floor: print x and y of it.",
    ),
    "point": Cause(
        "What is seen lies at a wrong place.",
        "The point on the floor is wrong, before its bearing and range are taken.",
        "Follow the ray: where does it leave the lens, how does it fall, where does it end?",
    ),
    "curve": Cause(
        "One ray counts too much, or too little.",
        "With one guess and one ray the likelihood is wrong already.",
        "Print where the ray ends, its cell, and the distance d there; then work out "
        "0.95 exp(-d² / (2 sigma²)) + 0.05 for that distance, and its logarithm.",
    ),
    "ends": Cause(
        "The rays end in wrong places.",
        "A ray straight ahead is right; one that is turned, by heading or bearing, is not.",
        "Draw the guess and its rays, and print where each of them ends.",
    ),
    "joined": Cause(
        "The rays together weigh too much, or too little.",
        "One ray is right; several of them, or several guesses, are not.",
        "The logarithms of all rays of a guess are added, for each guess anew.",
    ),
    "noise-of-step": Cause(
        "The cloud has another shape than the motion's noise makes.",
        "Without noise all is right; the noise has another size, or goes elsewhere, than due.",
        "Noise belongs to the first rotation, the way and the second rotation; compare each of the "
        "three variances with the stub.",
    ),
    "new-weights": Cause(
        "The cloud believes the wrong particles.",
        "The weights after the scan are wrong; resampling plays no part in it.",
        "New weight = old weight times exp(log-weight); then divide by their sum.",
    ),
    "after-drawing": Cause(
        "What the filter goes on with is not what was drawn.",
        "It resamples when it should, but poses or weights after it are not those of the draw.",
        "Return what parts.resample gives, both of it, unchanged.",
    ),
    "mean-alone": Cause(
        "The belief is at a wrong place.",
        "The mean after the look is wrong.",
        "mean + k * (seen - mean), with the mean after the step. Work out k for the case.",
    ),
    "spread-alone": Cause(
        "The belief is too sure of itself, or not sure enough.",
        "The mean is right; how sure it is is not.",
        "After the look the share 1 - k of the variance after the step is left; return its root.",
    ),
    "aim": Cause(
        "The robot aims at another point of its way than it should.",
        "Its speeds fit the direction to that point; it is the search for the point that is wrong.",
        "Print which point is the nearest, and how far away the points after it are: the first one "
        "farther than `ahead` is due, or the last one.",
    ),
    "speed-alone": Cause(
        "The robot drives too fast or too slowly.",
        "The turning speed is right; the speed is not.",
        "It is speed · cos(error), and 0 where that is negative and where the goal is reached.",
    ),
    "turn-alone": Cause(
        "The robot turns too much or too little.",
        "The speed is right; the turning speed is not.",
        "It is gain · error, with gain = 0.25 / delay and the error between -π and π.",
    ),
    "goal-alone": Cause(
        "The robot comes to its goal, and does not do there what it should.",
        "On the way all is right; at the goal it is not.",
        "Nearer than 10 mm the speed is 0, and the robot turns with gain · (goal[2] - heading), "
        "brought back to -π to π.",
    ),
}
