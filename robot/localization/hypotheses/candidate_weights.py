"""How likely are the places that a search has found, beside those that are followed?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from robot.geometry import Array, Pose2
from robot.localization.hypotheses.images import EQUAL
from robot.localization.hypotheses.place_search import PlaceSearch
from robot.localization.hypotheses.prior import Prior, log_prior
from robot.localization.hypotheses.track import Track
from robot.localization.hypothesis_parameters import HypothesisParameters


@dataclass(frozen=True, slots=True)
class FoundPlace:
    """A place where none is followed."""

    pose: Pose2
    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad]"""
    log_weight: float
    """Relative to the heaviest that is followed."""
    log_evidence: float
    """The same by the scans of the short map alone, whatever was known before."""


def found_places(
    search: PlaceSearch,
    tracks: Sequence[Track],
    priors: Sequence[Prior],
    log_elsewhere: float,
    whole: bool,
    p: HypothesisParameters,
) -> list[FoundPlace]:
    """Places beside the tracks, weighed as if they had been there all along.

    Args:
        search: that is done.
        tracks: heaviest first.
        priors: what was said of the start.
        log_elsewhere: log-weight of being at none of the tracks.
        whole: whether nothing but the short map tells the tracks from others.
        p: says what scans are worth.
    """
    lives = search.found_beside([track.pose for track in tracks])
    if not lives:
        return []
    reference, log_weight = _reference(search, tracks)
    worth = p.scan_worth * search.scans / search.scans_lived
    places = []
    for life in lives:
        evidence = log_weight + worth * float((life.fits - reference).sum())
        pose, weight = life.pose @ search.since, evidence
        if tracks and not whole:
            prior = log_prior(priors, pose, p.log_kidnapped)
            # One of the places elsewhere is no likelier than all of them together.
            weight = min(weight + prior, max(log_elsewhere, prior))
        places.append(FoundPlace(pose, life.covariance, weight, evidence))
    return places


def _reference(search: PlaceSearch, tracks: Sequence[Track]) -> tuple[Array, float]:
    """How the heaviest place that was lived through fits, and its log-weight."""
    for track in tracks:
        life = search.life_at(track.pose)
        if life is not None:
            return life.fits, track.log_weight
    return search.best_life.fits, 0.0


def equal_tracks(
    search: PlaceSearch, tracks: Sequence[Track], p: HypothesisParameters
) -> list[Pose2]:
    """Poses of the other tracks that fit the short map about as well as the heaviest does.

    A search may take two places that are near each other for one. Of such a track counts how well
    the last scans fit it.
    """
    leader = search.life_at(tracks[0].pose) if tracks else None
    worth = p.scan_worth * search.scans / search.scans_lived

    def is_equal(track: Track) -> bool:
        life = search.life_at(track.pose)
        if life is None or leader is None or life is leader:
            return track.fits_as_well
        return worth * float((life.fits - leader.fits).sum()) > EQUAL

    return [track.pose for track in tracks[1:] if is_equal(track)]


def has_rival(
    tracks: Sequence[Track],
    places: Sequence[FoundPlace],
    followed: Sequence[Pose2],
    symmetries: Sequence[Pose2],
    p: HypothesisParameters,
) -> bool:
    """Whether another place fits about as well as the heaviest, and is no image of it.

    Args:
        tracks: heaviest first.
        places: that a search has found beside the tracks.
        followed: poses of tracks that fit as well.
        symmetries: of the field, about its origin.
        p: says how near two places are one.
    """
    images = [turned @ track.pose for track in tracks[:1] for turned in symmetries]
    equal = [place.pose for place in places if place.log_evidence > EQUAL]
    return any(not any(p.alike(pose, image) for image in images) for pose in (*equal, *followed))
