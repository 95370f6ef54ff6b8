"""How the radio shows each emotion, sound and blink: tables of its controls."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RadioPose:
    """The controls of the radio; shares, degrees and centimetres.

    Attributes:
        bend: how far the ends of its chassis curve up [cm].
        stretch: by what share it grows taller, and narrower for that.
        swell: by what share it expands.
        shear: how far its top leans over towards +x, over its height.
        tilt, nod: how far all of it leans towards +x and to the front [degrees].
        wring: how far its ends are turned against each other [degrees].
        quake: height of the waves that run along it [cm].
        handle: how far the middle of the handle rises [cm].
        antenna, reach: how far the antenna leans out [degrees], and how much longer it is.
        knobs: how far the knobs are turned [degrees].
        upper, lower: how far the shutters over the speakers are open [degrees].
        slant: how much higher the shutters' outer ends stand; above 0 is fury, below is grief [degrees].
        squint: how much of its opening the speaker in +x loses.
        right, up: where the cones point [degrees].
        dilate: how much larger the dust caps and their rings are.
        push: how far the cones stand out [cm].
        toe: how far the speakers are turned in [degrees].
        big: by what share the speakers are larger.
        door: how far the door of the compartment is open [degrees].
        wide, tall: by what share the compartment is wider and taller.
        curve: how far the compartment's ends stand above its middle [cm].
        skew: how far its end in +x stands above the other [cm].
        out: how far the compartment is pushed out [cm].
        eject: how far the cassette comes out, from 0 to 1.
        reels: how far the reels are turned [degrees].
    """

    bend: float = 0.0
    stretch: float = 0.0
    swell: float = 0.0
    shear: float = 0.0
    tilt: float = 0.0
    nod: float = 0.0
    wring: float = 0.0
    quake: float = 0.0
    handle: float = 0.0
    antenna: float = 0.0
    reach: float = 0.0
    knobs: float = 0.0
    upper: float = 46.0
    lower: float = 44.0
    slant: float = 0.0
    squint: float = 0.0
    right: float = 0.0
    up: float = 0.0
    dilate: float = 0.0
    push: float = 0.0
    toe: float = 0.0
    big: float = 0.0
    door: float = 5.0
    wide: float = 0.0
    tall: float = 0.0
    curve: float = 0.0
    skew: float = 0.0
    out: float = 0.0
    eject: float = 0.0
    reels: float = 0.0


REST = RadioPose()
P = RadioPose

# fmt: off
EMOTIONS = {
    "serenity": P(
        bend=0.8, handle=0.2, knobs=20,
        upper=20, lower=26,
        door=0, wide=0.056, curve=0.7,
    ),
    "joy": P(
        bend=1.9, stretch=0.02, handle=0.9, antenna=8,
        upper=48, lower=14, dilate=0.1,
        door=32, wide=0.14, curve=1.1,
    ),
    "ecstasy": P(
        bend=3.2, stretch=0.03, swell=0.06, handle=1.8, antenna=22, reach=0.25, knobs=120,
        upper=66, lower=6, dilate=0.3, push=0.3, big=0.08,
        door=58, wide=0.2, tall=0.2, curve=1.7,
    ),
    "trust": P(
        bend=0.7, tilt=5, handle=0.3,
        lower=36, dilate=0.3,
        door=12, wide=0.042, curve=0.6,
    ),
    "admiration": P(
        bend=1.2, stretch=0.03, tilt=8, nod=-6, handle=0.9, reach=0.1,
        upper=62, lower=40, up=14, dilate=0.45,
        door=30, wide=-0.04, curve=0.8,
    ),
    "apprehension": P(
        bend=-0.5, stretch=0.02, quake=0.12, antenna=-10,
        upper=52, slant=-13, right=-12, dilate=-0.2,
        door=8, wide=0.042, curve=-0.25, skew=0.4,
    ),
    "fear": P(
        bend=-0.9, stretch=0.07, quake=0.2, handle=0.3, antenna=-22,
        upper=62, lower=52, slant=-23, dilate=-0.35, push=0.3,
        door=20, wide=0.098, curve=-0.5,
    ),
    "terror": P(
        bend=-1.4, stretch=0.12, quake=0.4, handle=1.2, antenna=-38, reach=0.3,
        upper=82, lower=66, slant=-26, dilate=-0.5, push=0.9, big=0.12,
        door=66, wide=0.042, tall=0.3, curve=-0.7,
    ),
    "surprise": P(
        stretch=0.06, handle=1.1, reach=0.2,
        upper=72, lower=60, dilate=-0.1, push=0.7, big=0.05,
        door=52, wide=-0.3, tall=0.12,
    ),
    "amazement": P(
        stretch=0.08, swell=0.08, handle=2.2, reach=0.45, knobs=60,
        upper=88, lower=76, dilate=-0.2, push=1.2, big=0.2,
        door=78, wide=-0.16, tall=0.4,
    ),
    "pensiveness": P(
        bend=-0.4, tilt=-5, nod=4,
        upper=22, lower=36, slant=-6, right=12, up=-10,
        door=0, wide=-0.16, skew=-0.3,
    ),
    "sadness": P(
        bend=-1.9, stretch=-0.04, nod=5, handle=-0.7, antenna=-30,
        upper=26, lower=34, slant=-26, up=-12,
        door=0, wide=-0.04, curve=-0.8,
    ),
    "grief": P(
        bend=-3.2, stretch=-0.09, tilt=-3, nod=8, handle=-1.4, antenna=-62, reach=-0.2,
        upper=10, lower=14, slant=-34,
        door=30, wide=0.07, curve=-1.3,
    ),
    "disgust": P(
        shear=-0.06, tilt=-4, wring=7, antenna=-8,
        upper=24, lower=12, slant=9, squint=0.35,
        door=36, curve=-0.7, skew=1, eject=0.5,
    ),
    "loathing": P(
        bend=-0.8, shear=-0.12, tilt=-6, nod=-6, wring=14, antenna=-24,
        upper=15, lower=8, slant=18, squint=0.25, right=12,
        door=55, wide=0.098, curve=-0.8, skew=0.9, eject=1,
    ),
    "annoyance": P(
        shear=0.05, handle=-0.3,
        upper=20, lower=30, slant=14, right=8,
        door=0, wide=-0.1, curve=-0.3, skew=0.25,
    ),
    "anger": P(
        bend=-0.5, shear=0.14, nod=4, handle=-0.6, antenna=14, knobs=-60,
        upper=28, lower=22, slant=31, dilate=-0.2, toe=10,
        door=14, wide=0.07, curve=-0.6,
    ),
    "rage": P(
        bend=-1, swell=0.07, shear=0.24, nod=7, quake=0.1, handle=0.7, antenna=30, knobs=-140,
        upper=40, lower=24, slant=44, dilate=-0.4, push=0.6, toe=18, big=0.06,
        door=60, wide=0.18, tall=0.22, curve=-0.9,
    ),
    "anticipation": P(
        bend=0.5, stretch=0.03, nod=5, handle=0.7, antenna=6, reach=0.2,
        upper=56, lower=38, up=6, dilate=0.1,
        door=14, wide=-0.1, curve=0.4, skew=0.35,
    ),
    "vigilance": P(
        stretch=0.09, nod=4, handle=0.6, antenna=4, reach=0.6,
        upper=48, lower=16, slant=10, right=15, dilate=-0.35,
        door=0, wide=-0.12, curve=-0.1,
    ),
    "love": P(
        bend=1.4, swell=0.03, tilt=7, handle=0.4,
        upper=34, lower=24, slant=-10, dilate=0.6,
        door=7, wide=-0.22, curve=0.8, out=0.5,
    ),
    "submission": P(
        bend=-1, stretch=-0.1, nod=12, handle=-1, antenna=-34,
        upper=34, lower=38, slant=-18, up=16, dilate=0.15,
        door=0, wide=-0.28, curve=0.25,
    ),
    "awe": P(
        bend=0.5, stretch=0.07, nod=-9, handle=1.3, reach=0.3,
        upper=76, lower=56, slant=-12, up=16, dilate=0.25, push=0.3,
        door=40, wide=-0.22, tall=0.2,
    ),
    "disapproval": P(
        bend=-1.2, tilt=5, nod=-5, wring=-4,
        upper=16, lower=36, slant=-5, right=-12, up=-8,
        door=0, wide=-0.14, curve=-1,
    ),
    "remorse": P(
        bend=-1.5, stretch=-0.04, tilt=-7, nod=9, handle=-1, antenna=-46,
        upper=17, lower=28, slant=-23, right=-11, up=-18,
        door=8, curve=-0.6, skew=-0.6,
    ),
    "contempt": P(
        shear=-0.07, tilt=-6, nod=-8, wring=5, antenna=10,
        upper=19, lower=24, slant=5, squint=0.55, right=14, up=-6,
        wide=-0.06, curve=0.1, skew=1.5,
    ),
    "aggressiveness": P(
        bend=0.7, swell=0.05, shear=0.1, nod=10, handle=-0.3, antenna=24, knobs=-90,
        upper=36, lower=14, slant=35, dilate=-0.3, push=0.4, toe=14,
        door=28, wide=0.18, curve=0.7,
    ),
    "optimism": P(
        bend=1.5, stretch=0.05, tilt=4, nod=-5, handle=1.1, antenna=12, reach=0.25,
        upper=54, lower=22, up=10, dilate=0.15,
        door=20, wide=0.084, curve=1.1, skew=0.3,
    ),
}
"""A row for the body, the eyes, the mouths, as far as they move."""

VISEMES = {
    "viseme_PP": P(door=0, wide=-0.04, out=-0.2),
    "viseme_FF": P(door=9, wide=0.03, tall=-0.1, curve=-0.15, reels=8),
    "viseme_TH": P(door=40, wide=0.014, tall=0.1, eject=0.4, reels=12),
    "viseme_DD": P(door=28, wide=0.035, curve=0.12, reels=25),
    "viseme_CH": P(door=24, wide=-0.22, tall=0.06, curve=-0.12, out=0.5, reels=-15),
    "viseme_SS": P(door=11, wide=0.11, tall=-0.1, curve=0.2, reels=-25),
    "viseme_RR": P(door=18, wide=-0.16, skew=0.25, out=0.25, reels=20),
    "viseme_aa": P(door=74, tall=0.3, reels=40),
    "viseme_E": P(door=50, wide=0.1, tall=0.06, curve=0.15, reels=30),
    "viseme_I": P(door=27, wide=0.19, tall=-0.06, curve=0.4, reels=15),
    "viseme_O": P(door=56, wide=-0.32, tall=0.22, out=0.3, reels=-40),
    "viseme_U": P(door=28, wide=-0.46, tall=-0.06, curve=-0.1, out=0.8, reels=-20),
}

BLINKS = {
    "blink_half": P(upper=15, lower=16),
    "blink_closed": P(upper=0, lower=0),
}
# fmt: on

POSES = {**EMOTIONS, **VISEMES, **BLINKS}
