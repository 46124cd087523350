"""More visits than a place's own list: sessions of light drawn at random."""

import numpy as np

from r3gw.benchmark.lights import Session


def with_visits(
    sessions: tuple[Session, ...], count: int, random: np.random.Generator
) -> tuple[Session, ...]:
    """The place's sessions, with as many training sessions as ``count`` says.

    Args:
        sessions: The place's own list.
        count: Training sessions to have; fewer than the list has take its first ones.
        random: Draws what the list lacks: sun, haze, clouds and a name of date and time.
    """
    trained = [session for session in sessions if not session.is_test][:count]
    names = {session.name for session in sessions}
    while len(trained) < count:
        drawn = _visit(random)
        if drawn.name not in names:
            names.add(drawn.name)
            trained.append(drawn)
    return (*trained, *(session for session in sessions if session.is_test))


def _visit(random: np.random.Generator) -> Session:
    """One session between eight in the morning and seven in the evening."""
    hour = float(random.uniform(8.0, 19.0))
    day, month = int(random.integers(1, 29)), int(random.integers(3, 11))
    noon = float(random.uniform(35.0, 62.0))
    elevation = 8.0 + (noon - 8.0) * np.sin(np.pi * (hour - 7.0) / 13.0)
    overcast = float(random.choice([0.0, 0.0, 0.0, 0.3, 0.9]))
    return Session(
        name=f"{day:02d}-{month:02d}_{int(hour):02d}_{int(60 * (hour % 1)):02d}",
        sun_azimuth_deg=round(90.0 + 180.0 * (hour - 7.0) / 13.0, 1),
        sun_elevation_deg=round(float(elevation), 1),
        turbidity=round(float(random.uniform(2.4, 5.5)), 1),
        overcast=overcast,
        clouds=round(float(random.uniform(0.15, 0.5)), 2),
    )
