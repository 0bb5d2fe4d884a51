"""What each control of the start window does: the texts that appear when the mouse rests on it."""

TOOLTIPS: dict[str, str] = {
    # call
    "code": "What the other one's window shows: a number and three words, or three words and a number. The words are "
    "the key of the encryption: let nobody else read them. Enter calls.",
    "address": "Name or address of the other machine, as its window shows it: HOST or HOST:PORT. A code with its "
    "number in front needs none.",
    "Call": "Call with the code: over the relay or in this network if its number is in front, else at the address.",
    "Wait for a call": "Show a code for the one who calls you. The call comes over the relay, or within this network.",
    "relay": "A machine with `conf relay`, by which two homes reach each other: HOST or HOST:PORT, the same at both "
    "ends. In one network none is needed.",
    "port": "UDP port at which this machine is called without a relay. 5005 unless another program uses it.",
    "Wait at this port": "Wait without a relay: show a code and the addresses of this machine.",
    "recent call": "Fill in the address. The code is a new one in each call.",
    "received call": "You were called from there; there is no address to call back.",
    "Clear": "Forget all recent calls.",
    "Animate a face": "Open the animator in a window of its own.",
    # devices
    "camera": "The camera whose image is tracked. Its image stays here: only control points are sent.",
    "microphone": "The microphone of your voice. The bar shows its level: it should move when you talk.",
    "speaker": "What you hear the other one with. Headphones are best.",
    "Test tone": "Play three notes through the speaker.",
    "Search again": "Look again for cameras, microphones and speakers, after one was plugged in.",
    # what others get
    "name": "Your name, shown to the other one; empty for none.",
    "head": "The head that the other one sees you with, unless you send photos.",
    "portrait": "Send small photos of your face, so that the other one sees yours and not a drawn head. "
    "Without it no image of you leaves this machine.",
    "link rate": "Never send more than this, headers included. Choose the rate of your link if it is slow.",
    # in a call
    "Copy the code": "Copy the code, to paste it into a message.",
    "Copy": "Copy this address.",
    "Stop waiting": "Go back; the code is then of no use (Escape).",
    "Cancel": "End the call (Escape).",
    "Hang up": "End the call.",
}


def tooltip_of(label: str) -> str:
    """Return the text of a control by its label; empty if there is none."""
    return TOOLTIPS.get(label.partition("##")[0] or label.removeprefix("##"), "")
