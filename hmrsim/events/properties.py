"""Properties of runs that do not hold."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._fields import Number


class PropertyViolated(
    Event,
    kind="property_violated",
    severity="error",
    subject=(),
    text="the property {property} is violated at {at} s: {text}",
    traced=False,
):
    """A property that is watched does not hold; only where a run is watched, so that traces do not have it."""

    property: Annotated[str, Field(description="The property's name.")]
    subject_: Annotated[str, Field(description="Whose fault it is, such as a robot or an order; empty for none.")]
    at: Annotated[
        Number, Field(description="When, in simulated seconds; it may be found with the next event that is watched.")
    ]
    reason: Annotated[str, Field(description="Why, as a short text without times and identifiers.")]
    text_: Annotated[str, Field(description="Why, as a sentence.")]


EVENTS: Final = EventGroup("properties", (PropertyViolated,))
