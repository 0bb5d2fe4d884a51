"""What each control of the animator does, with its unit: the texts that appear when the mouse rests on it."""

from conf.animator.keys import key_label

# Label -> text. A control whose name comes from a file or a list has the text of its kind; {name} stands for it there.
TOOLTIPS: dict[str, str] = {
    # files
    "mesh file": "Path of a face to open: OBJ, PLY, GLB, VRM, glTF or STL. A PPC file of the same name beside it is "
    "read too.",
    "PPC file": "Path of a file with the 50 control points, to load or to save.",
    "DPC file": "Path of recorded motion, as `conf extract` and the key D of `conf receive` write it.",
    "EPC file": "Path of a file with expressions; they become buttons above, those of the same name are replaced.",
    "Open": "Open the file that the field names.",
    "Load": "Read the control points from the file that the field names.",
    "...": "Choose the file in a dialog.",
    "Save PPC": "Write the control points to the file that the field above names; without a name, beside the face.",
    "Save as ...": "Choose in a dialog where the control points are written.",
    # control points
    "Find points": "Find the 50 control points by rendering the face and tracking the images. It takes some tens of "
    "seconds; the window can be used meanwhile.",
    "Place points ...": "Set or correct the 50 control points by hand, guided by a reference face.",
    "up axis": "The axis of the file that points to the crown of the head.",
    "front axis": "The axis of the file that points from the face to you.",
    "also place the mirrored point": "A click also sets the same point of the other side, mirrored at the middle of "
    "the face and moved to the surface.",
    "Left to right": "Replace every point of the subject's right side by the mirror image of its partner on the left.",
    "Undo": f"Take back the last change of the points ({key_label('undo')}).",
    "OK": "Use these points; possible when none is missing.",
    "Cancel": "Stop placing and keep the points from before.",
    "reference": "Click a point to place it next.",
    "Save and quit": "Write the control points to the PPC file named here, then close the window.",
    "Quit without saving": "Close the window; the points that you placed are lost.",
    "Do not quit": "Go back to the window.",
    "Discard the points": "Go back to the points from before you placed any.",
    "Go on placing": "Go back to placing the points.",
    # deformation
    "radial basis functions": "The control points move the skin around them: each displacement is interpolated by the "
    "kernel below.",
    "Waters' muscles": "Muscles pull the skin towards their roots (Waters 1987); their contractions are in the panel "
    "Muscles.",
    "kernel": "The function of distance by which a control point moves the skin: {name}.",
    "gaussian": "exp(-r²), r = distance times locality: local and soft; far from the points nothing moves.",
    "multiquadric": "sqrt(1 + r²), r = distance times locality: smooth and wide. The default.",
    "inverse-multiquadric": "1 / sqrt(1 + r²), r = distance times locality: smooth, fades with distance.",
    "linear": "r, the distance itself: little overshoot, slight creases at the points.",
    "thin-plate": "r² log r: bends the skin as little as possible, far-reaching.",
    "locality, 1/cm": "How quickly the influence of a control point falls with distance, in 1/cm: the distance is "
    "multiplied by it before the kernel is applied. High values move only the skin near the point.",
    "polynomial": "Polynomial added to the kernels: none, a constant, or linear, which reproduces shifts, turns and "
    "scaling of the whole face exactly.",
    "lambda": "Smoothing, without unit: 0 makes the skin follow every control point exactly; higher values follow "
    "less and damp noise.",
    "separate lips and eyelids": "A point of one lip or lid does not move the other: distances are measured along the "
    "skin.",
    "refine with blendshapes": "Correct the interpolation with the sculpted shapes of the shipped head.",
    "Reset to defaults": "Multiquadric kernel with its own locality, separate lips and eyelids, lambda 0.02.",
    "operator B": "The matrix from displacements of the 50 control points to those of all vertices: vertices x 50. It "
    "is built when kernel, locality, polynomial, lambda or regions change; each frame is one product with it.",
    # muscles
    "muscles move the face": "Deform by the muscles below instead of radial basis functions.",
    "preset": "Set all contractions and the jaw for: {name}.",
    "both sides together": "A slider contracts the muscles of both sides.",
    "muscle": "Contraction of {name}: 0 is relaxed, 1 would pull the skin all the way to the muscle's root.",
    "zygomatic major": "Contraction, 0 to 0.5: pulls the corner of the mouth up and out, as in a smile.",
    "risorius": "Contraction, 0 to 0.5: pulls the corner of the mouth sideways.",
    "depressor anguli": "Contraction, 0 to 0.5: pulls the corner of the mouth down.",
    "levator labii": "Contraction, 0 to 0.5: raises the upper lip.",
    "levator nasi": "Contraction, 0 to 0.5: raises the wing of the nose and wrinkles it.",
    "depressor labii": "Contraction, 0 to 0.5: lowers the lower lip.",
    "frontalis inner": "Contraction, 0 to 0.5: raises the inner part of the brow.",
    "frontalis outer": "Contraction, 0 to 0.5: raises the outer part of the brow.",
    "corrugator": "Contraction, 0 to 0.5: pulls the brows together and down.",
    "orbicularis oris": "Contraction, 0 to 0.5: rounds and protrudes the lips, as in a kiss.",
    "jaw, rad": "Rotation of the lower jaw about its hinge, in radians; 0.45 is wide open.",
    # expressions
    "emotion": "Play {name} once, or hold it until it is released.",
    "intensity": "Factor of the expression at its peak: 1 is as designed, 0 is nothing.",
    "onset, s": "Time from neutral to the peak of an expression, in seconds.",
    "hold, s": "Time that the peak lasts, in seconds.",
    "release, s": "Time from the peak back to neutral, in seconds.",
    "hold until released": "An expression stays at its peak until Release is pressed.",
    "Release": "Let the held expressions fade.",
    "idle motion: blinks, glances, sway": "Small random motion of eyes, lids and head, so that the face looks alive.",
    "action unit": "Intensity of action unit {name} (Ekman and Friesen's facial action coding), 0 to 1.",
    "Set all to zero": "Set all action units to 0.",
    # view
    "style": "Draw the face as: {name}.",
    "rendered": "The face with its materials and light.",
    "wireframe": f"The triangles of the mesh ({key_label('wireframe')}).",
    "regions": f"Colours show which control points move which skin ({key_label('regions')}).",
    "control points": f"Draw the control points on the face ({key_label('points')}).",
    "eye contact: the eyes look at you": f"Turn the eyes to the viewer, however the head is turned "
    f"({key_label('eye contact')}).",
    "light": "The lamps around the face.",
    "background": "What is behind the face, also in images and clips; green and blue are for chroma keying.",
    "direction": "Look at the face from: {name}.",
    "Reset rotation, position and zoom": f"Look straight at the face again ({key_label('reset')}).",
    "of": "The control point whose influence on the skin is coloured, blue none to yellow full.",
    # export
    "source": "What is written: the face as it is now, the recording, or an emotion.",
    "format": "File format; it changes the suffix of the file's name.",
    "file": "Path of the file to write; its suffix is the format.",
    "size, px": "Width x height of images and clips, in pixels.",
    "frames/s": "Frames per second of clips and motion files.",
    "Export": "Write the file.",
    "Cancel export": "Stop writing; a clip keeps the frames written so far.",
    # timeline
    "seek": "Time in the recording, in seconds: drag to go there.",
    "Play": f"Go on playing the recording ({key_label('play')}).",
    "Pause": f"Stop at this frame ({key_label('play')}).",
    "Stop": "Stop and go back to the start.",
    "<": f"One frame back ({key_label('step')}).",
    ">": f"One frame forward ({key_label('step')}).",
    "speed": "Playing speed as a multiple of the recorded one.",
    "loop": "Start again at the end.",
    "Record motion": "Record what moves the face now, emotions, action units and recordings, as a new recording.",
    "Stop recording": "End the record; it becomes the recording and can be exported.",
    "Close": "Close the recording; the face is moved by emotions again.",
}


def tooltip_of(label: str, kind: str = "") -> str:
    """Return the text of a control by its label, or of its kind; empty if there is none."""
    name = label.partition("##")[0] or label.removeprefix("##")
    return TOOLTIPS.get(name) or TOOLTIPS.get(kind, "").format(name=name)
