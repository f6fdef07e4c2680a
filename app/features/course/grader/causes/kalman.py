"""Mistakes in a Kalman filter: gains, means, variances."""

from __future__ import annotations

from app.features.course.grader.causes.cause import Cause

KALMAN = {
    "surer-alone": Cause(
        "A look that is a hair surer than the belief throws away all that was believed.",
        "The surer of the two is taken, and the other one forgotten.",
        "Both count, the surer one more: mean + k * (seen - mean).",
    ),
    "gain-of-step": Cause(
        "While it stands, no look changes anything, however unsure it is.",
        "The gain is made of the step's variance alone: how unsure the belief was is left out.",
        "Variance believed = variance before + variance of the step; the gain is made of that.",
    ),
    "gain-reversed": Cause(
        "The surer of two is believed less.",
        "The gain is the wrong way round.",
        "If the look is exact, the gain is 1: the new mean is what was seen.",
    ),
    "rest": Cause(
        "How sure it is after a look is not right.",
        "Another share of the variance is left than 1 - k.",
        "After an exact look k is 1. What is left then? Mind what is squared.",
    ),
    "away": Cause(
        "The belief moves away from what is seen.",
        "The difference of seen and believed has the wrong sign.",
        "If the place that is seen is larger than the believed one, the mean has to grow.",
    ),
    "variance-returned": Cause(
        "It is far too sure of itself.",
        "The variance is returned as the standard deviation.",
        "A standard deviation is the square root of a variance.",
    ),
    "seen-sure": Cause(
        "It believes each look entirely.",
        "The look counts as exact: its variance is left out of the gain.",
        "k = variance believed / (variance believed + variance seen).",
    ),
    "look-lost": Cause(
        "However often it looks, the belief stays where the wheels put it.",
        "What was seen does not change the mean.",
        "After the look the mean is mean + k * (seen - mean).",
    ),
    "gain-fixed": Cause(
        "A bad look spoils a good belief.",
        "Belief and look always count the same.",
        "Let the variances decide: the smaller one counts more.",
    ),
    "deviations-added": Cause(
        "The belief becomes unsure too quickly.",
        "Standard deviations are added in a step.",
        "Errors that have nothing to do with each other: their variances add.",
    ),
    "deviations-weigh": Cause(
        "The belief follows the look too much, or too little.",
        "The gain is made of standard deviations.",
        "The gain is a ratio of variances.",
    ),
    "step-lost": Cause(
        "The belief lags behind the robot.",
        "The step is not added to the mean.",
        "First the step, then the look.",
    ),
    "old-belief": Cause(
        "The belief runs ahead of the robot.",
        "What is seen is compared with where the robot was before the step.",
        "Add the step first; k * (seen - mean) is with the mean after it.",
    ),
    "step-sure": Cause(
        "The belief becomes too sure while driving.",
        "The step adds no variance.",
        "Each step is a little wrong: its variance is added.",
    ),
    "step-late": Cause(
        "The belief after a step and a look is not the one that is due.",
        "The gain, or what is left of the variance, is made of the variance before the step.",
        "First the step: a new mean and a new variance. All that follows is made of these.",
    ),
    "look-first": Cause(
        "The look is compared with where the robot was before.",
        "The look comes before the step.",
        "First the step, then the look.",
    ),
    "no-difference": Cause(
        "The belief runs away.",
        "What is seen is added, not how far it is from what was believed.",
        "If the place that is seen is the believed one, nothing is to be corrected.",
    ),
    "look-widens": Cause(
        "After a look the belief is less sure than before, or than the look alone.",
        "Another rule makes the variance: two that are known together are surer than either.",
        "After the look the share 1 - k of the variance after the step is left; return its root.",
    ),
    "never-surer": Cause(
        "However often it looks, it never becomes surer.",
        "The look does not make the variance smaller.",
        "After the look, the share 1 - k of the variance is left.",
    ),
}
