"""Mistakes in the filter of particles: weights, survivors, estimates, new particles."""

from __future__ import annotations

from app.features.course.grader.causes.cause import Cause

FILTER = {
    "R1": Cause(
        "What was seen once counts twice; the effective sample size falls and falls.",
        "The survivors keep their old weights.",
        "Copies already stand for the weight. After resampling each one weighs the same.",
    ),
    "R2": Cause(
        "Weights belong to other particles: their colours are strewn at random.",
        "New particles are drawn, but the weights keep their old order.",
        "After resampling each one weighs the same.",
    ),
    "R3": Cause(
        "Copies stick together: when one moves, all of them move, several times.",
        "Copies are the same object in memory, not copies.",
        "Make real copies: poses[indices] of a NumPy array does, [poses[i] for i in ...] does not.",
    ),
    "R4": Cause(
        "An unlikely particle survives, and a good one dies.",
        "The index is off by one.",
        "Try three particles with the weights 0, 1, 0 on paper. Which index comes out?",
    ),
    "R5": Cause(
        "While the robot stands, the filter becomes more and more certain, also of a wrong place.",
        "The same scan counts again and again while the robot stands.",
        "Return what you got if the robot has not moved.",
    ),
    "R6": Cause(
        "Only the last scan counts.",
        "The weights from before are thrown away.",
        "New weight = old weight times likelihood.",
    ),
    "E1": Cause(
        "The estimate looks the wrong way when the robot looks along -x.",
        "Headings are averaged as plain numbers: 3.1 and -3.1 give 0.",
        "Average cosines and sines and take arctan2, or average wrapped differences.",
    ),
    "E2": Cause(
        "Errors jump by a full turn.",
        "A heading, or a difference of headings, is not brought back to -π to π.",
        "(angle + π) % (2 π) - π wraps an angle.",
    ),
    "wrap-half": Cause(
        "The robot suddenly looks the other way.",
        "Headings are brought back by half a turn, π, instead of a whole one.",
        "A full circle is 2 π: (angle + π) % (2 π) - π wraps an angle.",
    ),
    "generator": Cause(
        "No run can be repeated.",
        "Chance comes from elsewhere than the generator that was given.",
        "Draw from rng alone: rng.random(), rng.standard_normal(n).",
    ),
    "no-chance": Cause(
        "Each run is the same as the last.",
        "Nothing is left to chance.",
        "Draw from rng: rng.random(), rng.standard_normal(n).",
    ),
    "line": Cause(
        "Who survives has little to do with the weights.",
        "The numbers do not lie on the line where the weights lie end to end.",
        "Print where each weight ends on the line, and the numbers: both go from 0 to 1, and grow.",
    ),
    "order-apart": Cause(
        "Who survives has little to do with the weights.",
        "The weights lie on the line in another order than the particles in their list: they were "
        "sorted or turned round, and the particles were not.",
        "Nothing has to be sorted. If you sort, take poses in the same order.",
    ),
    "start-anywhere": Cause(
        "The last one of the list gets far too many copies, and the first ones too few.",
        "The first number does not lie below 1/n: with the steps, the others run beyond the line's "
        "end.",
        "The first number lies below 1/n, and n - 1 steps follow. For four particles: how far "
        "does the last of them come?",
    ),
    "steps-lost": Cause(
        "The first ones of the list survive, whatever they weigh.",
        "All numbers lie below 1/n: the steps from the first to the others are missing.",
        "For four particles: the first number lies between 0 and 0.25. Where do the others lie?",
    ),
    "steps": Cause(
        "Those at the end of the list get too many copies, or too few.",
        "The steps along the line are not 1/n.",
        "n numbers, each 1/n farther than the one before: all of them lie below 1.",
    ),
    "filled-up": Cause(
        "The best one has far too many copies, and good ones have only one.",
        "Each particle survives once or not at all, and one of them fills up what is missing.",
        "Several numbers can lie under one weight: it gets as many copies.",
    ),
    "nearest-edge": Cause(
        "Neighbours of the right ones survive.",
        "A number takes the particle whose weight ends nearest to it, not the one it lies under.",
        "The first weight that ends beyond the number is the one it lies under: np.searchsorted of "
        "the sums.",
    ),
    "steps-stretched": Cause(
        "Those at the end of the list get too many copies, or too few.",
        "The numbers are spread out between the first one and an end that is not theirs, as 1: the "
        "steps are larger or smaller than 1/n.",
        "The first number is random, and so is the last: it is the first plus (n - 1) / n.",
    ),
    "undrawn": Cause(
        "The last one of the list survives each time, whatever it weighs.",
        "One survivor too few is drawn, and the last particle takes its place.",
        "All n survivors are drawn: n numbers on the line, and none but those.",
    ),
    "light-lost": Cause(
        "What seems unlikely now is forgotten for good.",
        "Particles that are lighter than the average never survive.",
        "Each survives as often as its weight says: who weighs half as much as the average, in "
        "every second draw.",
    ),
    "weights-ignored": Cause(
        "Bad particles count as much as good ones.",
        "The weights make no difference.",
        "Where do the weights come in?",
    ),
    "copies-fixed": Cause(
        "Particles that weigh less than 1/n never survive.",
        "How many copies a particle gets is rounded, and nothing left to chance.",
        "A particle that is due half a copy gets one in every second draw: chance decides.",
    ),
    "by-rank": Cause(
        "The same ones survive in each draw, and one without any weight can be among them.",
        "Who survives is decided by an order of the particles, not by chance and weight.",
        "Nobody is safe, and nobody lost: each survives as often as its weight says.",
    ),
    "one-survivor": Cause(
        "After one draw the whole cloud is a single particle.",
        "One number decides for all survivors.",
        "n survivors need n numbers on the line: the first one, and n - 1 steps from it.",
    ),
    "best-only": Cause(
        "One particle stands for the whole cloud.",
        "Only the heaviest particle is used.",
        "All particles count, each as much as it weighs.",
    ),
    "weights-changed": Cause(
        "The cloud follows the weights too much, or too little.",
        "Something else than the weight decides: a square or a root of it.",
        "A particle with twice the weight gets twice the copies.",
    ),
    "threshold": Cause(
        "It resamples at the wrong time.",
        "The effective sample size is compared with something else than half the particles.",
        "Of 4 particles, 1.8 is too few and 2.2 is enough.",
    ),
    "counts-twice": Cause(
        "The filter is too sure of itself, and soon of a wrong place.",
        "Something counts twice in one round: the scan, the old weights, or the step.",
        "Move once, weigh once, multiply once.",
    ),
    "moves-standing": Cause(
        "While the robot stands the cloud moves all the same.",
        "The particles are moved before it is asked whether the robot stands.",
        "Return what you got if the robot has not moved: poses and weights.",
    ),
    "log-returned": Cause(
        "The next round takes logarithms for weights.",
        "The logarithms of the weights are returned.",
        "exp makes weights of them; let their sum be 1.",
    ),
    "not-even": Cause(
        "Robots in some parts of the field are hardly ever found.",
        "The particles do not lie evenly: some parts have more than others.",
        "Each place and each heading is as likely as any other: that is rng.uniform.",
    ),
    "all-alike": Cause(
        "All particles are in the same place.",
        "One pose is drawn, and used for all.",
        "Draw count values for each of x, y and heading.",
    ),
    "xy": Cause(
        "Places are mirrored at the diagonal.",
        "x and y are exchanged.",
        "x counts from left to right, y from bottom to top.",
    ),
    "too-few": Cause(
        "The estimate jumps.",
        "Particles that belong to the place are left out.",
        "All within 0.1 m and 0.5 rad of the heaviest belong to it, each by its weight.",
    ),
    "half-arctan": Cause(
        "A robot that looks backwards is said to look ahead.",
        "The angle is the arctangent of a ratio, which knows half of the circle only.",
        "arctan2(y, x) tells all four quarters apart.",
    ),
    "one-replaced": Cause(
        "A robot that was carried off is found very late.",
        "Only one particle is new, however many are due.",
        "Each particle is replaced by itself: which index does the new one get?",
    ),
    "part-of-all": Cause(
        "The estimate is drawn towards other places.",
        "A part of it, the heading or x and y, is the mean of all particles, not only of those of "
        "the heaviest one's place.",
        "Average x, y, cosines and sines of the same particles, with the same weights.",
    ),
    "heading-of-one": Cause(
        "The estimate's heading jumps from scan to scan.",
        "The heading is that of one particle, and not a mean.",
        "Average the headings of all that belong to the place, as cosine and sine, by weight.",
    ),
    "place-of-one": Cause(
        "The estimate's place jumps from scan to scan.",
        "x and y are those of one particle, and not a mean.",
        "Average x and y of all that belong to the place, by weight.",
    ),
    "turn-alone": Cause(
        "The estimate looks along x, wherever the robot looks.",
        "The heading is the mean difference to the heaviest particle, without that particle's own.",
        "A mean of differences is a difference: to what does it have to be added?",
    ),
    "weights": Cause(
        "The weights mean nothing after resampling.",
        "The weights that come back are not all 1/n.",
        "Return np.full(n, 1 / n) with the survivors.",
    ),
    "invented": Cause(
        "There are particles that nobody put there.",
        "Poses are changed that should only be copied.",
        "Copy poses as they are; noise belongs to the motion.",
    ),
    "half-replaced": Cause(
        "Some particles are half old and half new.",
        "It is decided for x, y and heading apart which of them are replaced.",
        "One random number for each particle: rng.random(len(poses)). A particle is replaced as a "
        "whole.",
    ),
    "order": Cause(
        "The scan is compared with where the robot was before.",
        "Weighing comes before moving.",
        "Predict first, then correct.",
    ),
    "motion-lost": Cause(
        "The cloud stays behind while the robot drives.",
        "The poses that motion returns are not used.",
        "motion leaves its poses as they are, and returns new ones: keep those.",
    ),
    "survivors-lost": Cause(
        "Bad particles survive, although new ones are drawn.",
        "What parts.resample gives is not kept.",
        "parts.resample returns poses and weights; the old ones do not change by themselves.",
    ),
    "standing": Cause(
        "The robot moves, and the filter does not notice, or the other way round.",
        "It counts as standing though it drove or turned, or the way is another one than the "
        "length of (dx, dy).",
        "It stands only if both are small: the way, in any direction, and the turn, either way.",
    ),
    "standing-units": Cause(
        "The robot stands, and the filter goes on.",
        "Way and turn are taken together, or the turn is compared with the way's limit.",
        "The way is the length of (dx, dy) alone, and its limit is 0.001 m; that of the turn is "
        "0.01 rad.",
    ),
    "added": Cause(
        "A particle that fits nothing keeps its weight.",
        "The likelihood is added to the old weight.",
        "New weight = old weight times likelihood.",
    ),
    "not-normalized": Cause(
        "The effective sample size is nonsense.",
        "The weights do not sum to one.",
        "Divide the weights by their sum.",
    ),
    "drawn-unnormalized": Cause(
        "Who survives has little to do with the weights.",
        "The draw gets weights that do not sum to one.",
        "parts.resample lays the weights on a line from 0 to 1: divide them by their sum before.",
    ),
    "size-unnormalized": Cause(
        "It resamples at the wrong time.",
        "The effective sample size is that of weights which do not sum to one yet.",
        "Divide the weights by their sum first, then work out 1 / sum of squares.",
    ),
    "size-formula": Cause(
        "It resamples at the wrong time.",
        "The effective sample size is worked out by another rule, as by the largest weight or by "
        "how many are heavy.",
        "It is one over the sum of the squared weights: for four equal ones 1 / (4 · 0.25²) = 4.",
    ),
    "logs-divided": Cause(
        "How much a good fit counts for depends on the numbers' size, and it may count for less.",
        "The log-weights are divided by something before exp, as by the largest or by their sum.",
        "A ratio of likelihoods is a difference of logarithms: subtract the largest one, and "
        "divide by the sum only after exp.",
    ),
    "exponential": Cause(
        "Weights are negative, or the worse fit counts more.",
        "Log-weights are added to weights, or multiplied with them.",
        "exp makes a factor of a log-weight.",
    ),
    "no-resampling": Cause(
        "In the end one particle has all the weight.",
        "It never resamples, or much too late.",
        "Resample when the effective sample size is below half of the particles. Print it: if one "
        "weight is 1 and the others are 0, it is 1.",
    ),
    "resampling-always": Cause(
        "The cloud thins out for nothing.",
        "It resamples even if the weights are good.",
        "Resample only when the effective sample size is below half of the particles. Print it: "
        "for four equal weights it is 4.",
    ),
    "resampling-early": Cause(
        "The newest scan decides nothing until the next round.",
        "It resamples before it weighs.",
        "Move, weigh, then draw anew.",
    ),
    "resampling-reversed": Cause(
        "It resamples when it need not, and never when it must.",
        "The comparison is the wrong way round.",
        "A small effective sample size is the bad one.",
    ),
    "middle": Cause(
        "The robot is said to be between two places, where no particle is.",
        "Particles of other places count as well.",
        "Take only those near the heaviest: 0.1 m in place and 0.5 rad in heading, either way.",
    ),
    "heaviest": Cause(
        "The estimate is at an unlikely place.",
        "Another particle than the heaviest makes the place.",
        "The heaviest is the one with the largest weight: which index has it?",
    ),
    "shares": Cause(
        "The estimate is drawn towards x 0, y 0.",
        "The weights of those that count do not sum to one.",
        "A weighted mean is divided by the sum of the weights that are in it.",
    ),
    "diagonal": Cause(
        "All particles lie on one line.",
        "The same numbers serve twice, whether drawn or counted off.",
        "Draw separate numbers for x, for y and for the heading.",
    ),
    "field-size": Cause(
        "Particles lie beyond the field, or leave a part of it empty.",
        "A side of the field, its width or its height is not what it is, or the extent's order is "
        "another.",
        "The extent is left, bottom, right, top. How wide is a field from x 0.5 to 1.5 m?",
    ),
    "half-circle": Cause(
        "The robot is never found when it looks backwards.",
        "The headings do not cover the whole circle.",
        "Headings lie between -π and π.",
    ),
    "no-injection": Cause(
        "A robot that was carried off is never found again.",
        "No new particles appear.",
        "If the short memory is below the long one, something has happened. Is the share above 0 "
        "then?",
    ),
    "ratio": Cause(
        "New particles come at the wrong time.",
        "The share of new particles is not 1 - fast / slow: by another formula, or because a "
        "comparison is the wrong way round.",
        "All is well when both memories are equal, or the fast one is larger: then the share is 0.",
    ),
    "appended": Cause(
        "The cloud grows each time the robot seems lost.",
        "New particles come beside the old ones, and not in their place.",
        "As many come back as were given: poses[chosen] = anywhere(number of the chosen).",
    ),
    "left-out": Cause(
        "The cloud shrinks each time the robot seems lost.",
        "Only a part comes back: those that stay without the new ones, or the new ones alone.",
        "As many come back as were given: poses[chosen] = anywhere(number of the chosen).",
    ),
    "memory": Cause(
        "It reacts too late, or to nothing.",
        "The memories are not what they should be after this fit, or are used before.",
        "memory.slow += 0.05 * (fit - memory.slow); the fast one likewise, with 0.5.",
    ),
    "memory-falls-alone": Cause(
        "Once the fit was bad, the filter does not trust good scans again.",
        "Where the fit is as good as before, or better, the memories do not take it.",
        "Update both memories at each call, first of all; then decide whether new particles come.",
    ),
    "memory-unstored": Cause(
        "It reacts to one picture alone, or to nothing.",
        "The new values of the memories, or of one of them, are not kept.",
        "memory.slow and memory.fast themselves have to change, each time.",
    ),
    "memory-forgets": Cause(
        "The memories remember nothing but the newest fit.",
        "Of what a memory was before nothing is left: it is a share of the newest fit alone.",
        "memory.slow + 0.05 * (fit - memory.slow): what would come of it without the brackets?",
    ),
    "memory-mixed": Cause(
        "One memory follows the other instead of the fits.",
        "A memory is made of the other memory's value, and not of its own.",
        "memory.slow comes from memory.slow and the fit; memory.fast from memory.fast and the fit.",
    ),
    "memory-late": Cause(
        "It notices one picture too late.",
        "The share is worked out before the memories take the newest fit.",
        "First update both memories, then compare them.",
    ),
    "memory-grows": Cause(
        "The memories grow and grow.",
        "A share of the newest fit is added, but none of the old is let go.",
        "Each memory goes a share of the way from what it was to the newest fit: fit - memory.",
    ),
    "memory-shares": Cause(
        "It forgets too soon, or too late.",
        "A memory takes another share of the newest fit than is due, as what it should keep.",
        "The slow memory keeps 0.95 of what it was and takes 0.05 of the newest fit; the fast one "
        "takes half.",
    ),
    "rates": Cause(
        "New particles come when all is well.",
        "The two memories are exchanged.",
        "The slow one takes 0.05 of the newest fit, the fast one 0.5.",
    ),
    "chosen-twice": Cause(
        "Fewer new particles come than are due.",
        "Some particles are chosen twice to be replaced, and others in their place not at all.",
        "A draw may give the same index again. One random number for each particle, "
        "rng.random(len(poses)) < share, chooses none twice.",
    ),
    "one-place": Cause(
        "All new particles are at the same place.",
        "One new particle is used for all.",
        "Ask anywhere for as many as are replaced.",
    ),
    "all-new": Cause(
        "One bad picture, and all is forgotten.",
        "All particles are replaced, or none.",
        "Each particle is replaced with the probability of the share: one random number for each.",
    ),
    "same-places": Cause(
        "It is always the same particles that are replaced.",
        "The first or the last ones are replaced, not random ones.",
        "rng.random(len(poses)) < share chooses by chance.",
    ),
}
