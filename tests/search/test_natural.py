"""Plain English queries and the patterns they become."""

import pytest
from effort import examples
from hypothesis import given
from hypothesis import strategies as st

from lanindex.errors import PatternError
from lanindex.search.language import parse
from lanindex.search.language.natural import offer_reading, reading

SAID = {
    # A limb, and up or down
    "right arm raised": "r_arm high",
    "raise right hand": "r_arm high",
    "raise the right hand": "r_arm high",
    "raises his left arm": "l_arm high",
    "lift your left arm": "l_arm high",
    "hand up": "arm high",
    "hands up": "arms high",
    "both hands up": "arms high",
    "an arm goes up": "arm high",
    "arm goes up": "arm high",
    "the right arm is raised": "r_arm high",
    "right arm rises": "r_arm rising",
    "put the right arm down": "r_arm low",
    "lower the right arm": "r_arm low",
    "the left arm moves down": "l_arm low",
    "arms down": "arms low",
    "right arm sinks": "r_arm sinking",
    "both arms raised": "arms high",
    "raise both arms": "arms high",
    "one arm up": "arm high",
    "either hand up": "arm high",
    "left and right arm up": "arms high",
    "raise your right and left arm": "arms high",
    "R_ARM up": "r_arm high",
    "raise left knee": "l_thigh mid/high",
    "right leg up": "r_leg mid/high",
    "lift the right elbow": "r_upper_arm mid/high",
    # Over the head, hanging, at the height of the shoulders
    "hands above head": "arms high",
    "arms above the head": "arms high",
    "right hand over her head": "r_arm high",
    "arms overhead": "arms place high",
    "raise arms straight up": "arms place high",
    "right arm straight down": "r_arm place low",
    "arms hanging": "arms place low",
    "right arm at shoulder height": "r_arm mid",
    "raise the right arm to shoulder height": "r_arm mid",
    "left arm horizontal": "l_arm mid",
    "arms parallel to the floor": "arms mid",
    # Directions
    "both arms to the side": "arms side",
    "arms out to the sides": "arms side",
    "stretch both arms sideways": "arms side",
    "right arm to the right": "r_arm right",
    "left hand to the right": "l_arm right",
    "right arm forwards": "r_arm forward",
    "right arm in front of the body": "r_arm forward",
    "reach forward with the left hand": "l_arm forward",
    "arm behind the back": "arm back",
    "hands behind his back": "arms back",
    "point forward with right arm": "r_arm forward",
    "spread your arms": "arms side",
    "arms wide open": "arms side",
    "left leg kicks forward": "l_leg forward",
    "kick forward with the right leg": "r_leg forward",
    "right leg swings back": "r_leg back",
    "legs apart": "legs side",
    "right arm across the chest": "r_arm across",
    "right lower arm up": "r_forearm high",
    "legs crossed": "legs across/across_forward",
    "arms crossed": "forearms at across 0.5s+",
    "cross your arms": "arms across/across_forward",
    # Direction and height
    "raise the right arm to the side": "r_arm side mid/high",
    "raise both arms forward": "arms forward mid/high",
    "right arm forward and up": "r_arm forward high",
    "arms up to the side": "arms side high",
    "right arm to the side at shoulder height": "r_arm side mid",
    "lift the right leg to the side": "r_leg side",
    # Head and trunk
    "bend forward": "torso forward",
    "bend the right knee": "r_leg bend",
    "he bends both elbows, then raises the right arm": "arms bend -> r_arm high",
    "lean back": "torso back",
    "leans to the left": "torso left",
    "lean to the side": "torso right/left",
    "upper body forward": "torso forward",
    "head turns left": "head_turn left",
    "palms up": "palms high",
    "the right palm faces forward": "r_palm forward",
    "raise the right hand with the left palm facing back": "r_arm high with l_palm back",
    "turn the head to the right": "head_turn right",
    "tilt the head to the right": "head right",
    # Being there, and staying there
    "hold the right arm up": "r_arm at high",
    "keep both hands above your head": "arms at high",
    "right arm stays up": "r_arm at high",
    "right arm motionless": "r_arm still",
    "keep the head still": "head still",
    "Hands up!": "arms high",
    "lift both arms, then put them down.": "arms high -> low",
    # Several
    "right arm up and left arm down": "r_arm high with l_arm low",
    "right arm up, left arm to the side": "r_arm high with l_arm side",
    "raise the right arm while the left arm is down": "r_arm high with l_arm low",
    "right arm and head forward": "r_arm forward with head forward",
    "right arm up or left arm up": "r_arm high or l_arm high",
    "arms down then up": "arms low -> high",
    "raise the right arm and then lower it": "r_arm high -> low",
    "right arm up, later down": "r_arm high ... low",
    "r_arm lowered -> raised": "r_arm low -> high",
    "r_arm up ... down": "r_arm high ... low",
    "right arm goes from low to high": "r_arm low ... high",
    "the left arm moves from the side to the front": "l_arm side ... forward",
    "right arm above the shoulder": "r_arm high",
    "right knee up": "r_thigh mid/high",
}
UNSAID = [
    # Not movements of a limb to a place
    *("walk", "somebody waves", "jump up", "spin about", "clap hands"),
    "right hand on left hip",
    "hands together",
    "shrug shoulders",
    # Said of something else than a part, or of no part
    *("up", "raise", "goes up", "kick forward", "left and right"),
    # More than one thing at once, or not said which
    "arms up and down",
    "right arm up left arm down",
    "head moves left and right",
    "bend the right knee forward",
    "bend the head",
    "lean the leg",
    "raise left foot",
    "lower the arms to the side",
    "arms at his sides",
    "head up",
    "head down",
    "the body moves forward",
    "put the right arm back",
    "arms down at the sides",
    "right arm down the side",
    "hold hands",
    "right arm up or left arm up and head back",
    "lower arms to the side",
    "raise the right arm from the side to the front",
    "walk from left to right",
    "cross the right leg over the left leg",
    "wave the right arm up",
    # Conditions that are not heard must not be lost
    "right arm not raised",
    "never raise the right arm",
    "raise right arm quickly",
    "raise right arm twice",
    "raise right arm 2s",
    "right arm up without left arm",
    "arms up after legs apart",
    # Typing mistakes are another's
    "r_arm rihgt up",
]


@pytest.mark.parametrize("text", SAID)
def test_plain_words_lead_to_the_pattern(text: str) -> None:
    with pytest.raises(PatternError) as caught:
        parse(text)
    assert caught.value.found.endswith(SAID[text]), caught.value.found
    assert "Did you mean:  " in caught.value.found
    assert parse(SAID[text])


@pytest.mark.parametrize("text", UNSAID)
def test_nothing_else_is_put_into_peoples_mouths(text: str) -> None:
    assert reading(text) is None


def test_the_place_of_the_mistake_stays() -> None:
    with pytest.raises(PatternError) as caught:
        parse("right arm raised")
    assert str(caught.value).splitlines() == [
        "right arm raised",
        "          ^^^^^^",
        'I don\'t know "raised". Did you mean:  r_arm high',
    ]
    with pytest.raises(PatternError) as caught:
        parse("raise right hand", ["r_arm", "head"])
    assert caught.value.found == 'I don\'t know "raise". Did you mean:  r_arm high'


def test_what_no_capture_of_the_library_shows_is_offered_too() -> None:
    with pytest.raises(PatternError) as caught:
        parse("turn around", ["l_arm", "head"])
    assert caught.value.found.endswith("Did you mean:  turn >150deg")


SIDES = ["right", "left", "both", "the"]
WORDS = [*SIDES, "arm", "arms", "hand", "leg", "head", "raise", "up", "down", "to", "side", "and"]


@examples(200)
@given(st.lists(st.sampled_from(WORDS), min_size=1, max_size=7))
def test_whatever_is_read_is_a_pattern(words: list[str]) -> None:
    read = reading(" ".join(words))
    if read is not None:  # "hand touch arm" is written hand_touch arm
        assert parse(str(parse(read))) == parse(read)


def test_what_an_error_says_already_is_not_offered_again():
    with pytest.raises(PatternError) as error:
        parse("hop")
    offer_reading(error.value, parse)
    assert error.value.found == "Name the part first: jump hop"
