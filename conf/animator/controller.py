"""The animator's controller: owns the editor state and carries out what the user asks for."""

from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.animator.background_fit import BackgroundFit, FitFunction
from conf.animator.face_document import (
    DEFAULT_AXES,
    FaceDocument,
    open_face_document,
    save_points,
    with_axes,
    with_points,
)
from conf.animator.face_instance import FaceInstance
from conf.animator.file_dialog import FileDialog, FileRequest
from conf.animator.file_export import SUFFIXES, ExportOptions, check_output, export, export_still, parse_fps, parse_size
from conf.animator.motion_mixer import mix_motion
from conf.animator.motion_player import (
    REST_POSE,
    MotionPlayer,
    MotionSample,
    load_motion_clip,
    make_expression_clip,
    peak_time,
)
from conf.animator.state.editor import CURRENT_VIEW, RECORDING, EditorState
from conf.animator.state.point_placement import PointPlacement
from conf.atomic_write import interrupted_note, partial_path
from conf.errors import ConfError, explain
from conf.face.animation.action_units import load_emotions
from conf.face.animation.expression_state import ExpressionState
from conf.face.animation.idle_motion import IdleMotion
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.deformation.face_model import DeformerOptions
from conf.face.formats.dpc import MotionClip
from conf.face.formats.epc import ExpressionSet, read_epc
from conf.face.formats.ppc import read_ppc
from conf.face.mesh.mesh import MESH_SUFFIXES
from conf.face.symmetry import MIRROR_INDICES
from conf.output.image_writer import next_free_path
from conf.output.motion_recorder import MotionRecorder

# Text field -> title, kind and suffixes of the files that its dialog offers, and whether a new file may be named.
FILE_DIALOGS: dict[str, tuple[str, str, Sequence[str], bool]] = {
    "face": ("Open a face", "face meshes", MESH_SUFFIXES, False),
    "points": ("Load control points", "control points", (".ppc",), False),
    "saved points": ("Save the control points", "control points", (".ppc",), True),
    "recording": ("Open a recording", "recorded motion", (".dpc",), False),
    "expressions": ("Open expressions", "expressions", (".epc",), False),
    "output": ("Export as", "what can be exported", SUFFIXES, True),
}
REST = MotionSample(np.zeros((CONTROL_POINT_COUNT, 3), np.float32), REST_POSE)


class Controller:
    """Replaces `state` on every change, and holds the objects that are no plain data.

    expressions : everything that can be played; notice : text for the user, cleared when it is shown
    reports : lines for the terminal about the files written
    export_progress : 0 to 1, None if no export is running
    Methods that use files put the text of a ConfError into `notice`.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        document: FaceDocument,
        fit: FitFunction | None = None,
        *,
        file_dialog: FileDialog | None = None,
    ) -> None:
        """Open a document. fit : finds control points, also those of `document` if it has none; None if unavailable."""
        self.ctx = ctx
        self.state = EditorState()
        self.face = FaceInstance(ctx, document, DeformerOptions())
        self.fitting = BackgroundFit(fit)
        self.player: MotionPlayer | None = None
        self.recorder: MotionRecorder | None = None
        self.expressions: ExpressionSet = load_emotions()
        self.export_progress: float | None = None
        self.notice = ""
        self._file_dialog = file_dialog or FileDialog()
        self._has_unsaved_points = False  # placed by hand
        self.reports: list[str] = []
        self._export: Iterator[float] | None = None
        self._output = Path()
        self._idle = IdleMotion(np.random.default_rng())
        self._last_frame = (self.face.model.neutral, REST)
        self.find_missing_points()

    def update(self, now: float) -> None:
        """Use the results of background tasks, and write the next frame of a running export."""
        self.state = replace(self.state, expression=self.state.expression.without_finished(now))
        self.face.update(self.state.deformer, self.state.muscles)
        with self.errors_as_notice():
            self._poll_fit()
        self._poll_file_dialog(now)
        if self._export is None:
            return
        try:
            self.export_progress = next(self._export)
        except StopIteration:
            self._end_export()
            self.on_saved(self._output)
        except ConfError as error:
            self._end_export()
            self.notice = explain(error)

    def deform(self, now: float) -> tuple[NDArray[np.float32], MotionSample]:
        """Return the (V, 3) vertices to draw, and the motion they show; a running recorder records the motion."""
        state, model = self.state, self.face.model
        if state.placement is not None or self.face.document.points is None:
            self._last_frame = (model.neutral, REST)
        elif state.muscles.active:
            sample = mix_motion(None, ExpressionState(idle=state.expression.idle), self._idle, state.view, now)
            offsets = self.face.muscle_vertices(state.muscles) - model.neutral
            self._last_frame = (model.deform(sample.displacements) + offsets, sample)
        else:
            sample = mix_motion(self.player, state.expression, self._idle, state.view, now)
            if self.recorder is not None:
                self.recorder.add(sample.displacements, sample.pose.to_vector(), now)
            self._last_frame = (model.deform(sample.displacements), sample)
        return self._last_frame

    @contextmanager
    def errors_as_notice(self) -> Iterator[None]:
        """Put the text of a ConfError that is raised inside into `notice`."""
        try:
            yield
        except ConfError as error:
            self.notice = explain(error)

    def on_saved(self, path: Path) -> None:
        """Tell the user the full path of a file that was written."""
        self.notice = f"saved {path.absolute()}"
        self.reports.append(self.notice)

    def open_file(self, path: Path, now: float) -> None:
        """Open a mesh, control points, a recording or expressions, by the suffix."""
        path = path.expanduser()
        suffix = path.suffix.lower()
        with self.errors_as_notice():
            if suffix in MESH_SUFFIXES:
                self._show(open_face_document(path))
                # Save must not write over the points of the face before.
                self.state = replace(self.state, fields=replace(self.state.fields, points=""))
                self.find_missing_points()
            elif suffix == ".ppc":
                self._show(with_points(self.face.document, read_ppc(path)))
            elif suffix == ".dpc":
                self.play_clip(path.name, load_motion_clip(path, self.face.model.fapu), now)
            elif suffix == ".epc":
                self._add_expressions(read_epc(path).in_fapu(self.face.model.fapu))
            else:
                raise ConfError(f"{path}: open a mesh ({', '.join(MESH_SUFFIXES)}), a .ppc, a .dpc or an .epc file")
            self.notice = f"opened {path.name}"

    def play_clip(self, name: str, clip: MotionClip, now: float) -> None:
        """Make a clip the recording and play it in a loop."""
        self.player = MotionPlayer(name, clip)
        self.player.start(now)

    def play_expression(self, name: str, now: float) -> None:
        """Start an expression; radial basis functions deform the face from now on."""
        expression = self.state.expression.play(name, self.expressions[name], now)
        self.state = replace(self.state, expression=expression, muscles=replace(self.state.muscles, active=False))

    def toggle_recorder(self, now: float) -> None:
        """Start to record the motion, or stop: the recorded motion becomes the recording."""
        if self.recorder is None:
            self.recorder = MotionRecorder()
            return
        clip, self.recorder = self.recorder.finish(), None
        if clip is not None:
            self.play_clip("recorded motion", clip, now)
            self.notice = "motion recorded; Export writes it as DPC, clip, FAP or CSV"

    @property
    def points_path(self) -> Path:
        """The PPC file that Save writes: that of the text field, else the one beside the mesh."""
        typed, document = self.state.fields.points.strip(), self.face.document
        if typed:
            return Path(typed).expanduser()
        own = document.path.with_suffix(".ppc")
        return Path(own.name) if document.is_default else own  # the shipped head's folder belongs to the program

    def save_points(self, path: Path) -> bool:
        """Write the control points to a PPC file. Returns whether they are saved."""
        with self.errors_as_notice():
            save_points(path, self.face.document)
            self._has_unsaved_points = False
            self.on_saved(path)
        return not self._has_unsaved_points

    def choose_file(self, field: str) -> None:
        """Open the file dialog of a text field, a key of FILE_DIALOGS; the file that is chosen is used at once."""
        title, kind, suffixes, save = FILE_DIALOGS[field]
        if field == "saved points":
            typed = str(self.points_path)
        else:
            typed = getattr(self.state.fields, field).strip()
        start = Path(typed).expanduser() if typed else self.face.document.path.parent
        if self.face.document.is_default and not typed:
            start = Path()
        self.notice = self._file_dialog.open(FileRequest(field, title, start.absolute(), kind, suffixes, save))

    def find_points(self) -> None:
        """Start to find the control points in the background."""
        document = self.face.document
        self.fitting.start(document.path, (None, None) if document.axes == DEFAULT_AXES else document.axes)

    def find_missing_points(self) -> None:
        """Find the control points if the face has none and fitting is available."""
        if self.face.document.points is None and self.fitting.available:
            self.find_points()

    def set_axes(self, up: str, front: str) -> None:
        """Set the up and front axes of the file of a face without control points."""
        with self.errors_as_notice():
            self._show(with_axes(self.face.document, up, front))

    def place_points(self) -> None:
        """Start to place the control points by hand, from the known ones if there are any."""
        points = self.face.document.points
        self.state = replace(
            self.state,
            placement=PointPlacement() if points is None else PointPlacement(points.copy()),
            view=replace(self.state.view, style="rendered"),
            expression=replace(self.state.expression, units={}),
        )

    @property
    def has_unsaved_points(self) -> bool:
        """Whether control points that were placed by hand would be lost."""
        placement = self.state.placement
        return self._has_unsaved_points or (placement is not None and bool(placement.history))

    def cancel_placement(self, *, confirmed: bool = False) -> None:
        """Stop placing points; ask first if that loses some and the user has not confirmed it."""
        placement = self.state.placement
        ask = placement is not None and bool(placement.history) and not confirmed
        self.state = replace(self.state, question="cancel" if ask else None, placement=placement if ask else None)

    def request_quit(self) -> bool:
        """Tell whether the window may close; if that loses points and the user was not asked, open the question."""
        if not self.has_unsaved_points or self.state.question == "quit":
            return True
        self.state = replace(self.state, question="quit")
        return False

    def save_for_quit(self) -> bool:
        """Save all points, placed or set already. Returns whether they are saved; else the question is closed."""
        if self.state.placement is not None:
            self.apply_points()
        saved = self.state.placement is None and self.save_points(self.points_path)
        if not saved:
            self.state = replace(self.state, question=None)
        return saved

    def mirror_points(self) -> None:
        """Set every point of the right side to the mirror image of its placed partner."""
        if self.state.placement is None:
            return
        placement = self.state.placement.push_undo()
        for point in placement.left_points:
            placement = placement.set_point(MIRROR_INDICES[point], self.mirrored(placement, placement.points[point]))
        self.state = replace(self.state, placement=placement)

    def mirrored(self, placement: PointPlacement, position: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the (3,) position on the mesh that is the mirror image of a position."""
        picker = self.face.picker
        return picker.project_to_surface(placement.mirrored(position, picker.centre_x))

    def apply_points(self) -> None:
        """Rebuild the face with the placed points, if none is missing."""
        placement, document = self.state.placement, self.face.document
        if placement is None or placement.missing:
            return
        with self.errors_as_notice():
            self._show(with_points(document, document.to_file_coordinates(placement.points)))
            view = replace(self.state.view, camera=self.state.view.camera.reset())
            self.state = replace(self.state, view=view)
            self._has_unsaved_points = True
            self.notice = "the control points are placed; Save PPC saves them"

    def export(self) -> None:
        """Export what the export panel describes; `update` writes the frames of a clip."""
        fields = self.state.fields
        with self.errors_as_notice():
            options = self._export_options(Path(fields.output).expanduser())
            check_output(options.output)
            if fields.source == CURRENT_VIEW:
                self._export_view(options)
            else:
                clip, peak = self._source_clip(fields.source, parse_fps(fields.fps))
                self._output = options.output
                self._export = export(self.face.model, clip, replace(options, at=peak), self.ctx)
                self.export_progress = 0.0

    def cancel_export(self) -> None:
        """Stop the running export; what was written of a clip stays beside it."""
        self._end_export()
        note = f"; {interrupted_note(self._output.absolute())}" if partial_path(self._output).exists() else ""
        self.notice = f"export cancelled{note}"

    def save_screenshot(self, folder: Path) -> None:
        """Save the current view as JPEG, in the size of the export panel."""
        with self.errors_as_notice():
            self._export_view(self._export_options(next_free_path(folder, "conf", ".jpg")))

    def release(self) -> None:
        """Stop exports, wait for background tasks, free all GPU objects."""
        self._end_export()
        self._file_dialog.close()
        self.fitting.close()
        self.face.release()

    def _show(self, document: FaceDocument) -> None:
        face = FaceInstance(self.ctx, document, self.state.deformer)
        self.face.release()
        self.face = face
        self._last_frame = (face.model.neutral, REST)
        self._has_unsaved_points = False
        self.state = replace(
            self.state, placement=None, question=None, muscles=replace(self.state.muscles, active=False)
        )

    def _poll_file_dialog(self, now: float) -> None:
        """Use the file that was chosen in a dialog."""
        chosen = self._file_dialog.poll()
        if chosen is None:
            return
        request, path = chosen
        field = "points" if request.purpose == "saved points" else request.purpose
        fields = replace(self.state.fields, **{field: str(path)})
        self.state = replace(self.state, fields=fields)
        if not request.save:
            self.open_file(path, now)
        elif request.purpose == "saved points":
            self.save_points(path)

    def _poll_fit(self) -> None:
        """Use the points of a fit that has ended, unless another face was opened or points are being placed."""
        result = self.fitting.poll()
        document = self.face.document
        if result is None or result[0] != document.path or self.state.placement is not None:
            return
        self._show(with_points(document, result[1].points))
        found = "the control points are found; Place points corrects them, Save PPC saves them"
        self.notice = ". ".join((found, *result[1].remarks))

    def _add_expressions(self, added: ExpressionSet) -> None:
        old = self.expressions
        kept = [i for i, name in enumerate(old.names) if name not in added.names]
        names = (*(old.names[i] for i in kept), *added.names)
        self.expressions = ExpressionSet(names, np.concatenate([old.displacements[kept], added.displacements]))

    def _export_options(self, output: Path) -> ExportOptions:
        fields = self.state.fields
        return ExportOptions(output, parse_size(fields.size), parse_fps(fields.fps), view=self.state.view)

    def _export_view(self, options: ExportOptions) -> None:
        export_still(self.face.model, *self._last_frame, options, self.ctx)
        self.on_saved(options.output)

    def _source_clip(self, source: str, fps: float) -> tuple[MotionClip, float]:
        """Return the clip of an export source, and the seconds of its peak."""
        if source == RECORDING and self.player is not None:
            return self.player.clip, 0.0
        if source not in self.expressions.names:
            raise ConfError("choose what to export: the current view, the recording or an emotion")
        state = self.state.expression
        clip = make_expression_clip([self.expressions[source]], state.envelope, fps=fps, idle=state.idle)
        return clip, peak_time(state.envelope)

    def _end_export(self) -> None:
        if isinstance(self._export, Generator):
            self._export.close()
        self._export, self.export_progress = None, None
