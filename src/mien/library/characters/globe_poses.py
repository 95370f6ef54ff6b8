"""How the globe shows each emotion, sound and blink: tables of its controls."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class GlobePose:
    """The controls of the globe; shares, degrees, and centimetres of its largest mouth.

    Attributes:
        stretch: by what share it grows taller, and thinner for that.
        pear: by what share it is wider above than in the middle, and narrower below.
        tilt, nod: how far it leans towards +x and to the front [degrees].
        spikes: length of the spikes on its back and crown [cm].
        heave: how far its continents rise [cm].
        shiver: height of the waves that run around it [cm].
        ears: how far the ears are perked, or droop below 0 [degrees].
        flare, sniff: how much wider the noses are, and how far up they are drawn [cm].
        upper, lower: how far the lids are open [degrees].
        slant: how much higher the lids' outer ends stand; above 0 is fury, below is grief [degrees].
        brow: how far the brows are raised [degrees].
        squint: how much of the opening the eyes of one side lose.
        right, up: where it looks [degrees].
        dilate: how much larger the pupils are.
        pop: how far the eyes stand out [cm].
        stalks: how far the eyes on stalks rise, or sink below 0 [cm].
        wide: how much wider the mouths are.
        open_up, open_low: how far the lips stand open.
        curve: how far the corners stand above the middle of the mouths.
        skew: how far one corner stands above the other.
        pucker: how far the lips are pushed out.
        thick: how much thicker the lips are.
        tongue: how far the tongues are out.
    """

    stretch: float = 0.0
    pear: float = 0.0
    tilt: float = 0.0
    nod: float = 0.0
    spikes: float = 0.0
    heave: float = 0.0
    shiver: float = 0.0
    ears: float = 0.0
    flare: float = 0.0
    sniff: float = 0.0
    upper: float = 42.0
    lower: float = 32.0
    slant: float = 0.0
    brow: float = 0.0
    squint: float = 0.0
    right: float = 0.0
    up: float = 0.0
    dilate: float = 0.0
    pop: float = 0.0
    stalks: float = 0.0
    wide: float = 0.0
    open_up: float = 0.05
    open_low: float = 0.05
    curve: float = 0.35
    skew: float = 0.0
    pucker: float = 0.0
    thick: float = 0.0
    tongue: float = 0.0


REST = GlobePose()
P = GlobePose

# fmt: off
EMOTIONS = {
    "serenity": P(
        stretch=0.02, ears=6,
        upper=22, lower=20, brow=2,
        wide=0.08, open_up=0, open_low=0, curve=1.3,
    ),
    "joy": P(
        stretch=0.04, ears=16,
        upper=40, lower=12, brow=8, dilate=0.1,
        wide=0.22, open_up=0.1, open_low=1.1, curve=1.9,
    ),
    "ecstasy": P(
        stretch=0.08, pear=0.05, ears=26, flare=0.1,
        upper=62, lower=4, brow=22, dilate=0.3, pop=0.2, stalks=1.2,
        wide=0.24, open_up=0.25, open_low=2.3, curve=2.5, tongue=0.25,
    ),
    "trust": P(
        tilt=6, ears=8,
        upper=44, lower=26, brow=8, dilate=0.3,
        wide=0.05, open_up=0.02, open_low=0.25, curve=1.2,
    ),
    "admiration": P(
        tilt=9, nod=-6, ears=14,
        upper=60, lower=34, brow=22, up=16, dilate=0.45, stalks=0.6,
        wide=0.02, open_up=0.1, open_low=0.75, curve=1.6,
    ),
    "apprehension": P(
        stretch=-0.02, ears=-8,
        upper=48, lower=34, slant=-10, brow=12, right=-16, dilate=-0.25,
        wide=0.1, open_up=0.12, open_low=0.12, curve=-0.52, skew=0.35,
    ),
    "fear": P(
        stretch=0.05, pear=-0.04, spikes=0.7, shiver=0.1, ears=-18,
        upper=62, lower=42, slant=-16, brow=20, dilate=-0.35, pop=0.2, stalks=0.3,
        wide=0.22, open_up=0.35, open_low=0.5, curve=-1,
    ),
    "terror": P(
        stretch=0.09, pear=0.06, spikes=2.3, shiver=0.22, ears=-28,
        upper=78, lower=58, slant=-18, brow=30, dilate=-0.55, pop=0.6, stalks=1.6,
        wide=0.12, open_up=1.2, open_low=1.9, curve=-1.5,
    ),
    "surprise": P(
        stretch=0.05, ears=18,
        upper=66, lower=46, brow=28, dilate=-0.15, pop=0.3, stalks=0.9,
        wide=-0.4, open_up=0.8, open_low=1.1, curve=0.1, pucker=0.25,
    ),
    "amazement": P(
        stretch=0.1, pear=0.04, heave=0.3, ears=30,
        upper=82, lower=62, brow=36, dilate=-0.3, pop=0.7, stalks=2,
        wide=-0.22, open_up=1.4, open_low=2.4, curve=0.2, pucker=0.1,
    ),
    "pensiveness": P(
        tilt=-5, nod=5, ears=-8,
        upper=20, lower=26, slant=-6, brow=-2, right=14, up=-14,
        wide=-0.16, open_up=0, open_low=0, curve=-0.15, skew=-0.3,
    ),
    "sadness": P(
        stretch=-0.06, pear=-0.05, nod=7, ears=-30,
        upper=24, lower=24, slant=-20, up=-14, stalks=-0.8,
        wide=-0.04, open_up=0.02, open_low=0.02, curve=-2,
    ),
    "grief": P(
        stretch=-0.12, pear=-0.06, tilt=-4, nod=9, ears=-48, sniff=0.2,
        upper=9, lower=9, slant=-26, brow=-4, stalks=-1.5,
        wide=0.1, open_up=0.3, open_low=0.9, curve=-2.8, thick=0.1,
    ),
    "disgust": P(
        tilt=-6, ears=-8, flare=0.25, sniff=0.8,
        upper=20, lower=8, slant=6, brow=-10, squint=0.35,
        open_up=0.55, open_low=0.15, curve=-1.4, skew=0.7, tongue=0.35,
    ),
    "loathing": P(
        stretch=-0.05, tilt=-9, nod=-6, heave=0.3, ears=-16, flare=0.4, sniff=1.1,
        upper=13, lower=5, slant=14, brow=-12, squint=0.2, right=12,
        wide=0.12, open_up=0.6, open_low=1, curve=-2.1, skew=0.9, tongue=1,
    ),
    "annoyance": P(
        ears=-6, flare=0.1,
        upper=18, lower=20, slant=12, brow=-12, right=10,
        wide=-0.08, curve=-0.75, skew=0.25,
    ),
    "anger": P(
        stretch=-0.04, pear=0.04, nod=5, spikes=0.5, heave=0.4, ears=-14, flare=0.35,
        upper=26, lower=14, slant=26, brow=-16, dilate=-0.2,
        wide=0.1, open_up=0.5, open_low=0.35, curve=-1.5,
    ),
    "rage": P(
        stretch=-0.08, pear=0.07, nod=7, spikes=1.8, heave=0.9, shiver=0.08, ears=-24, flare=0.6, sniff=0.4,
        upper=38, lower=20, slant=38, brow=-14, dilate=-0.45, pop=0.5,
        wide=0.18, open_up=1.1, open_low=1.5, curve=-1.7,
    ),
    "anticipation": P(
        stretch=0.04, nod=5, ears=22,
        upper=52, lower=30, brow=14, up=8, dilate=0.1, stalks=0.7,
        wide=-0.1, open_up=0.1, open_low=0.3, curve=0.8, skew=0.3,
    ),
    "vigilance": P(
        stretch=0.09, nod=4, ears=36, flare=0.1,
        upper=46, lower=10, slant=9, brow=2, right=18, dilate=-0.4, stalks=1.8,
        wide=-0.06, open_up=0, open_low=0, curve=-0.22, thick=-0.2,
    ),
    "love": P(
        tilt=8, heave=0.15, ears=10,
        upper=32, lower=16, slant=-8, brow=6, dilate=0.65,
        wide=-0.1, open_up=0, open_low=0.1, curve=1.6, pucker=0.35, thick=0.3,
    ),
    "submission": P(
        stretch=-0.08, nod=13, ears=-22,
        upper=34, lower=28, slant=-14, brow=8, up=22, dilate=0.2, stalks=-1,
        wide=-0.28, open_up=0, open_low=0, curve=0.5, thick=-0.15,
    ),
    "awe": P(
        stretch=0.05, nod=-9, ears=12,
        upper=70, lower=44, slant=-10, brow=26, up=20, dilate=0.25, pop=0.2, stalks=1.2,
        wide=-0.25, open_up=0.35, open_low=0.9, curve=-0.15,
    ),
    "disapproval": P(
        tilt=5, nod=-5, ears=-12,
        upper=14, lower=28, slant=-4, brow=-6, right=-14, up=-10,
        wide=-0.14, open_up=0, open_low=0, curve=-2.2, skew=-0.2, thick=0.15,
    ),
    "remorse": P(
        stretch=-0.05, tilt=-8, nod=10, ears=-34, sniff=0.3,
        upper=15, lower=20, slant=-18, right=-14, up=-24,
        wide=0.02, open_up=0.1, open_low=0.12, curve=-1.4, skew=-0.55,
    ),
    "contempt": P(
        tilt=-7, nod=-8, ears=4, flare=0.15, sniff=0.3,
        upper=17, lower=16, slant=4, brow=-4, squint=0.55, right=16, up=-8,
        wide=-0.06, open_low=0.02, curve=-0.15, skew=1.5,
    ),
    "aggressiveness": P(
        pear=0.06, nod=10, spikes=1.1, heave=0.5, ears=10, flare=0.4,
        upper=34, lower=8, slant=28, brow=-14, dilate=-0.35, pop=0.3,
        wide=0.2, open_up=0.55, open_low=0.7, curve=0.9,
    ),
    "optimism": P(
        stretch=0.06, tilt=4, nod=-5, ears=26,
        upper=50, lower=18, brow=18, up=12, dilate=0.15, stalks=0.9,
        wide=0.12, open_low=0.55, curve=1.8, skew=0.25,
    ),
}
"""A row for the body, the eyes, the mouths, as far as they move."""

VISEMES = {
    "viseme_PP": P(wide=-0.1, open_up=0, open_low=0, curve=0.2, pucker=0.12, thick=-0.35),
    "viseme_FF": P(open_up=0.42, open_low=-0.1, curve=0.25, thick=-0.2),
    "viseme_TH": P(wide=-0.04, open_up=0.45, open_low=0.35, curve=0.2, tongue=0.85),
    "viseme_DD": P(wide=0.08, open_up=0.2, open_low=0.7, tongue=0.05),
    "viseme_CH": P(wide=-0.3, open_up=0.55, open_low=0.55, curve=0.1, pucker=0.4, thick=0.15),
    "viseme_SS": P(wide=0.2, open_up=0.25, open_low=0.2, curve=0.5, thick=-0.2),
    "viseme_RR": P(wide=-0.2, open_up=0.3, open_low=0.45, curve=0.2, pucker=0.2, thick=0.12, tongue=0.25),
    "viseme_aa": P(wide=0.02, open_up=0.7, open_low=2.3, curve=0.4),
    "viseme_E": P(wide=0.16, open_up=0.45, open_low=1.1, curve=0.6, thick=-0.1),
    "viseme_I": P(wide=0.24, open_up=0.35, open_low=0.5, curve=0.8),
    "viseme_O": P(wide=-0.44, open_up=1, open_low=1.5, curve=0, pucker=0.35),
    "viseme_U": P(wide=-0.62, open_up=0.4, open_low=0.5, curve=0, pucker=0.75, thick=0.1),
}

BLINKS = {
    "blink_half": P(upper=14, lower=14),
    "blink_closed": P(upper=0, lower=0),
}
# fmt: on

POSES = {**EMOTIONS, **VISEMES, **BLINKS}
