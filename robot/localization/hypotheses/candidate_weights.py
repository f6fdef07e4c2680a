"""Weights of places that a search has found; and places that look the same on a symmetric field."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from robot.geometry import Array, Pose2, turned_covariance
from robot.localization.hypotheses.place_search import PlaceSearch
from robot.localization.hypotheses.rescoring import Rescored
from robot.localization.hypotheses.start_poses import Prior, log_prior
from robot.localization.hypotheses.track import Track
from robot.localization.parameters import HypothesisParameters

EQUAL = -3.0
"""Log-weight relative to the heaviest place from which on the images of a place are followed.
Half: certain in 31.9 % of pictures instead of 30.5; twice: 30.0; misleading as often."""
OPEN = -10.0
"""A place that fits a short map worse by more, as log-weight, is refuted by it. Half and twice: no
claim of 36 robots changes (docs/integrity.md: scattered and carried ones of the default)."""


def missing_images(
    tracks: Sequence[Track], symmetries: Sequence[Pose2], parameters: HypothesisParameters
) -> Iterator[tuple[Pose2, Array, float]]:
    """Yield images of the heaviest tracks that are not followed; the others get the same weight.

    They are places that look like a followed one: pose, covariance (3, 3) [m, m, rad], log-weight.
    """
    for track in tracks:
        if track.log_weight < EQUAL:
            continue
        for turned in symmetries:
            pose = turned @ track.pose
            target = [item for item in tracks if parameters.alike(pose, item.pose)]
            for each in target:
                each.log_weight = max(each.log_weight, track.log_weight)
            if not target:
                covariance = turned_covariance(track.best.covariance, turned.theta)
                yield pose, covariance, track.log_weight


@dataclass(frozen=True, slots=True, eq=False)
class FoundPlace:
    """A place that a search has found, and that no track follows yet."""

    pose: Pose2
    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad]"""
    log_weight: float
    """Relative to the heaviest track."""
    log_evidence: float
    """The same by the short map's scans alone; at most, if all fits that unseen floor returned."""


def weigh_places(
    search: PlaceSearch,
    tracks: Sequence[Track],
    priors: Sequence[Prior],
    log_elsewhere: float,
    whole: bool,
    p: HypothesisParameters,
) -> list[FoundPlace]:
    """Return the found places without a track, weighed as if they had been followed all along.

    Args:
        search: a finished search.
        priors: the given start.
        log_elsewhere: log-weight of being at none of the tracks.
        whole: whether the short map is the only evidence for the tracks; then no prior counts.
        p: the parameters; they say what a scan is worth.
    """
    candidates = search.places_apart_from([track.pose for track in tracks])
    if not candidates:
        return []
    reference, log_weight = _reference(search, tracks)
    worth = p.scan_worth * search.scans / search.scans_replayed
    places = []
    for candidate in candidates:
        evidence = log_weight + worth * float((candidate.fits - reference.fits).sum())
        possible = evidence + worth * float((candidate.unseen - reference.unseen).sum())
        pose, weight = candidate.pose @ search.since, evidence
        if tracks and not whole:
            prior = log_prior(priors, pose, p.log_kidnapped)
            # One place elsewhere cannot be likelier than all places elsewhere together.
            weight = min(weight + prior, max(log_elsewhere, prior))
        places.append(FoundPlace(pose, candidate.covariance, weight, possible))
    return places


def _reference(search: PlaceSearch, tracks: Sequence[Track]) -> tuple[Rescored, float]:
    """Return the heaviest replayed track and its log-weight, or the best place."""
    for track in tracks:
        candidate = search.rescored_at(track.pose)
        if candidate is not None:
            return candidate, track.log_weight
    return search.best_rescored, 0.0


def rival_poses(
    search: PlaceSearch,
    tracks: Sequence[Track],
    places: Sequence[FoundPlace],
    symmetries: Sequence[Pose2],
    p: HypothesisParameters,
    least: float,
) -> list[Pose2]:
    """Return where the robot may be besides the heaviest track, and at no image of that.

    A search may take two places that are near each other for one. For a track that shares its place
    with the heaviest, or was not replayed, the last scans decide; below ``EQUAL`` it always counts.

    Args:
        search: a finished search.
        tracks: heaviest first.
        places: places that the search has found beside the tracks.
        symmetries: the field's symmetries, as transformations of the map.
        p: the parameters; they say how close two poses are one place.
        least: log-weight by the short map, relative to the heaviest, from which on a place counts.
    """
    images = [turned @ track.pose for track in tracks[:1] for turned in symmetries]
    leader = search.rescored_at(tracks[0].pose) if tracks else None
    worth = p.scan_worth * search.scans / search.scans_replayed

    def fits(track: Track) -> bool:
        candidate = search.rescored_at(track.pose)
        if candidate is None or leader is None or candidate is leader:
            return track.fits_like_best or least < EQUAL
        gain = candidate.fits + candidate.unseen - (leader.fits + leader.unseen)
        return worth * float(gain.sum()) > least

    poses = [place.pose for place in places if place.log_evidence > least]
    poses += [track.pose for track in tracks[1:] if fits(track)]
    return [pose for pose in poses if not any(p.alike(pose, image) for image in images)]
