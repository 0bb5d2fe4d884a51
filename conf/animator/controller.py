"""Carries out what the panels ask for: files, the recording's clock, the placing of points, exports."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.animator import commands as ask
from conf.animator.background_fit import BackgroundFit, FitFunction
from conf.animator.face_document import DEFAULT_AXES, open_face_document, save_points, with_axes, with_points
from conf.animator.face_instance import FaceInstance
from conf.animator.file_export import ExportOptions, OffscreenFrameRenderer, check_output, export, parse_fps, parse_size
from conf.animator.motion_clips import make_expression_clip, peak_time
from conf.animator.motion_mixer import MotionSample
from conf.animator.motion_player import MotionPlayer, NamedClip, load_motion_clip
from conf.animator.state.editor import CURRENT_VIEW, RECORDING, EditorState
from conf.animator.state.point_placement import PointPlacement, left_points, mirror_point
from conf.errors import ConfError
from conf.face.animation.action_units import load_emotions
from conf.face.animation.idle_motion import IdleMotion
from conf.face.formats.dpc import MotionClip
from conf.face.formats.epc import ExpressionSet, read_epc
from conf.face.formats.ppc import read_ppc, write_ppc
from conf.face.symmetry import MIRROR_INDICES
from conf.output.media_writer import IMAGE_FORMATS, VIDEO_FORMATS, next_free_path, save_image
from conf.output.motion_recorder import MotionRecorder
from conf.output.obj_writer import write_obj

MESHES = (".obj", ".ply", ".glb", ".stl")
SEED = 2007  # of the idle life beside an exported emotion
FOUND = "the control points are found: Place points corrects them, Save PPC keeps them"
CANCELLED = "the export was ended; a clip holds what was drawn so far"


class Controller:
    """Holds what is no plain data: the actor, the player, exports under way."""

    def __init__(self, ctx: moderngl.Context, actor: FaceInstance, fit: FitFunction | None = None) -> None:
        """fit : what finds control points by itself"""
        self.fitting = BackgroundFit(fit)
        self.desk = EditorState()
        self.actor = actor
        self.player: MotionPlayer | None = None
        self.emotions: ExpressionSet = load_emotions()
        self.recorder: MotionRecorder | None = None
        self.progress: float | None = None
        self.notice = ""
        self.last_frame: tuple[NDArray[np.float32], MotionSample] | None = None
        self.ctx = ctx
        self._exporting: Iterator[float] | None = None
        self._handlers: dict[type[Any], Callable[[Any, float], None]] = {
            ask.OpenFile: self._open,
            ask.SavePoints: self._save_points,
            ask.PlacePoints: self._place_points,
            ask.FitPoints: self._fit_points,
            ask.SetAxes: self._stand,
            ask.MirrorPoints: self._mirror_points,
            ask.ApplyPoints: self._accept_points,
            ask.CancelPlacement: lambda _request, _now: self._change(placing=None),
            ask.PlayExpression: self._play,
            ask.ReleaseExpressions: lambda _request, now: self._change(expressing=self.desk.expressing.release(now)),
            ask.TogglePlaying: lambda _request, now: self._with_player(lambda p: p.toggle(now)),
            ask.Stop: lambda _request, now: self._with_player(lambda p: p.clock.stop(now)),
            ask.Seek: lambda request, now: self._with_player(lambda p: p.clock.seek(request.position, now)),
            ask.StepFrames: lambda request, now: self._with_player(lambda p: p.step(request.frames, now)),
            ask.SetSpeed: lambda request, now: self._with_player(lambda p: p.clock.set_speed(request.speed, now)),
            ask.SetLoop: self._set_loop,
            ask.CloseRecording: self._close_recording,
            ask.ToggleMotionRecording: self._record_take,
            ask.Export: self._write_file,
            ask.CancelExport: lambda _request, _now: self._end_export(CANCELLED),
        }

    def handle(self, request: ask.Request, now: float) -> None:
        """Do what was asked for; what goes wrong with files becomes a notice."""
        try:
            self._handlers[type(request)](request, now)
        except ConfError as error:
            self.notice = str(error)

    def update(self) -> None:
        """Take the points that were found, write the next picture of an export that is under way."""
        self._take_fitted()
        if self._exporting is None:
            return
        try:
            self.progress = next(self._exporting)
        except StopIteration:
            self._end_export(f"saved {self.desk.fields.output}")
        except ConfError as error:
            self._end_export(str(error))

    def play(self, recording: NamedClip, now: float, *, loop: bool = True) -> None:
        """Put a recording on and play it."""
        self.player = MotionPlayer(recording, loop=loop)
        self.player.clock.start(now)

    def save_screenshot(self, folder: Path) -> None:
        """Write a picture of what is shown, in the size of the export panel."""
        fields = self.desk.fields
        self._change(fields=replace(fields, source=CURRENT_VIEW, output=str(next_free_path(folder, "conf", ".jpg"))))
        self.handle(ask.Export(), 0.0)
        self._change(fields=fields)

    def release(self) -> None:
        """End what is under way, free the actor."""
        self._end_export("")
        self.fitting.close()
        self.actor.release()

    def _change(self, **parts: Any) -> None:
        self.desk = replace(self.desk, **parts)

    def _with_player(self, act: Callable[[MotionPlayer], None]) -> None:
        if self.player is not None:
            act(self.player)

    def _open(self, request: ask.OpenFile, now: float) -> None:
        path = request.path.expanduser()
        suffix = path.suffix.lower()
        if suffix in MESHES:
            self._show(FaceInstance(self.ctx, open_face_document(path), self.desk.deformer))
            self.notice = f"opened {path.name}"
            self.find_missing_points()
        elif suffix == ".ppc":
            self._show(FaceInstance(self.ctx, with_points(self.actor.subject, read_ppc(path)), self.desk.deformer))
            self.notice = f"loaded {path.name}"
        elif suffix == ".dpc":
            self.play(load_motion_clip(path, self.actor.face.fapu), now)
            self.notice = f"playing {path.name}"
        elif suffix == ".epc":
            self._add_expressions(read_epc(path).in_fapu(self.actor.face.fapu))
            self.notice = f"opened {path.name}"
        else:
            raise ConfError(f"{path}: open a mesh ({', '.join(MESHES)}), a .ppc, a .dpc or an .epc file")

    def _add_expressions(self, added: ExpressionSet) -> None:
        before = self.emotions
        kept = [i for i, name in enumerate(before.names) if name not in added.names]
        names = (*(before.names[i] for i in kept), *added.names)
        self.emotions = ExpressionSet(names, np.concatenate([before.displacements[kept], added.displacements]))

    def _show(self, actor: FaceInstance) -> None:
        self.actor.release()
        self.actor = actor
        self._change(placing=None, muscling=replace(self.desk.muscling, active=False))

    def _save_points(self, request: ask.SavePoints, _now: float) -> None:
        save_points(request.path, self.actor.subject)
        self.notice = f"saved {request.path}"

    def _place_points(self, _request: ask.PlacePoints, _now: float) -> None:
        points = self.actor.subject.points
        placing = PointPlacement() if points is None else PointPlacement(points.copy())
        look = replace(self.desk.look, style="rendered")
        self._change(placing=placing, look=look, expressing=replace(self.desk.expressing, units={}))

    def find_missing_points(self) -> None:
        """Look for the control points of a face that has none, if anything can."""
        if self.actor.subject.points is None and self.fitting.available:
            self.handle(ask.FitPoints(), 0.0)

    def _fit_points(self, _request: ask.FitPoints, _now: float) -> None:
        subject = self.actor.subject
        self.fitting.start(subject.path, (None, None) if subject.axes == DEFAULT_AXES else subject.axes)

    def _take_fitted(self) -> None:
        """Build the face on points that were found, unless the user has opened another or places them by hand."""
        try:
            found = self.fitting.poll()
        except ConfError as error:
            self.notice = str(error)
            return
        subject = self.actor.subject
        if found is None or found[0] != subject.path or self.desk.placing is not None:
            return
        self._show(FaceInstance(self.ctx, with_points(subject, found[1].points), self.desk.deformer))
        self.notice = ". ".join((FOUND, *found[1].remarks))

    def _stand(self, request: ask.SetAxes, _now: float) -> None:
        self._show(FaceInstance(self.ctx, with_axes(self.actor.subject, request.up, request.front), self.desk.deformer))

    def _mirror_points(self, _request: ask.MirrorPoints, _now: float) -> None:
        placing = self.desk.placing
        if placing is None:
            return
        placing = placing.push_undo()
        for point in left_points(placing):
            place = placing.points[point]
            placing = placing.set_point(MIRROR_INDICES[point], self.mirror(placing, place))
        self._change(placing=placing)

    def mirror(self, placing: PointPlacement, place: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the (3,) place on the mesh that lies opposite to one."""
        picker = self.actor.picker
        return picker.project_to_surface(mirror_point(place, placing.middle(picker.middle)))

    def _accept_points(self, _request: ask.ApplyPoints, _now: float) -> None:
        placing = self.desk.placing
        if placing is None or placing.missing:
            return
        subject = self.actor.subject
        self._show(FaceInstance(self.ctx, with_points(subject, subject.to_file(placing.points)), self.desk.deformer))
        look = self.desk.look
        self._change(look=replace(look, view=look.view.reset()))
        self.notice = "the points are placed; Save PPC keeps them"

    def _play(self, request: ask.PlayExpression, now: float) -> None:
        expressing = self.desk.expressing.play(request.name, self.emotions[request.name], now)
        self._change(expressing=expressing, muscling=replace(self.desk.muscling, active=False))

    def _set_loop(self, request: ask.SetLoop, _now: float) -> None:
        if self.player is not None:
            self.player.clock.loop = request.loop

    def _close_recording(self, _request: ask.CloseRecording, _now: float) -> None:
        self.player = None

    def _record_take(self, _request: ask.ToggleMotionRecording, now: float) -> None:
        if self.recorder is None:
            self.recorder = MotionRecorder()
            return
        clip, self.recorder = self.recorder.finish(), None
        if clip is not None:
            self.play(NamedClip("take", clip), now)
            self.notice = "this is your take: Export writes it as DPC, clip, FAP or CSV"

    def _write_file(self, _request: ask.Export, _now: float) -> None:
        fields = self.desk.fields
        wish = ExportOptions(
            Path(fields.output).expanduser(),
            parse_size(fields.size),
            parse_fps(fields.fps),
            look=replace(self.desk.look, view=replace(self.desk.look.view, help=False)),
        )
        check_output(wish.output)
        if fields.source == CURRENT_VIEW:
            self._write_shown(wish)
            self.notice = f"saved {wish.output}"
            return
        motion, at = self._motion(fields.source, wish.fps or 30.0)
        self._exporting = export(self.actor.face, motion, replace(wish, at=at), self.ctx)
        self.progress = 0.0

    def _motion(self, source: str, fps: float) -> tuple[MotionClip, float]:
        if source == RECORDING and self.player is not None:
            return self.player.recording.motion, 0.0
        envelope = self.desk.expressing.envelope
        idle = IdleMotion(np.random.default_rng(SEED)) if self.desk.expressing.idle else None
        if source not in self.emotions.names:
            raise ConfError("choose what is to be exported: what is shown, a recording or an emotion")
        return make_expression_clip(self.emotions[source], envelope, fps=fps, idle=idle), peak_time(envelope)

    def _write_shown(self, wish: ExportOptions) -> None:
        suffix = wish.output.suffix.lower()
        if self.last_frame is None:
            return
        vertices, moment = self.last_frame
        if suffix in IMAGE_FORMATS:
            camera = OffscreenFrameRenderer(self.ctx, self.actor.face, wish)
            try:
                save_image(wish.output, camera.take_vertices(vertices, moment.pose))
            finally:
                camera.release()
        elif suffix == ".obj":
            write_obj(wish.output, self.actor.face.mesh, self.actor.face.to_file_coordinates(vertices))
        elif suffix == ".ppc":
            points = self.actor.face.deformed_points(moment.displacements)
            write_ppc(wish.output, self.actor.face.to_file_coordinates(points))
        else:
            kinds = "clips" if suffix in VIDEO_FORMATS else "motion files"
            raise ConfError(f"{kinds} need a motion: choose a recording or an emotion as the source")

    def _end_export(self, notice: str) -> None:
        self._exporting, self.progress = None, None
        if notice:
            self.notice = notice
