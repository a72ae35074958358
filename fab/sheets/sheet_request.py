"""Request for sheets: what they are made of, which machine cuts them, how many, in which files."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

from fab.drawings.closed_slots import SLOT_REACH, require_wider
from fab.drawings.cut_paths import Operation
from fab.drawings.cut_settings import CutSetting
from fab.drawings.drawing_files import PROGRAMS, USUAL, DrawingStyle, SheetFormat
from fab.sheets.crease_styles import EngraveStyle, NoStyle, ScoreStyle
from fab.sheets.cut_wishes import CutWishes
from fab.sheets.materials import Machine, Material, Speeds, perforation_for
from fab.sheets.perforation_settings import PerforationSettings
from fab.sheets.pieces import SheetSplit
from fab.sheets.registration import Registration
from solver.errors import InvalidState, InvalidValue, require_count

__all__ = ["SheetRequest"]

# Between two pieces on a sheet, in mm, and at least in kerfs.
_GAP_MM = 2.0
_GAP_KERFS = 4.0
# Mitres of sharp corners may reach out from a piece by up to this many kerfs.
_CORNER_KERFS = 5.0
# Lower tabs hold no glue.
_LEAST_TAB_MM = 1.0


@dataclass(frozen=True)
class SheetRequest:
    """What is asked for, and what follows from it for pieces, creases and speeds.

    Attributes
    ----------
    copies : of the pattern, 1 or more.
    registration : where given, creases are scored on the side on which they open, and each sheet
        has a front and a back (`fab.sheets.registration`); the stock is as large as the bed.
    formats : of the drawings. With one that the machine follows line by line, all of them hold
        dashes, whatever the machine's profile.
    page, guide : whether a result page shows them, and pages for print say how they are put
        together.
    stock_sheets : how many sheets are at hand; None where that is not known.
    grain_deg : direction in the pattern that is to lie along the grain of the sheet, 0 for x; None
        where it matters no more than the rotations of the material say.
    piece_gap_mm : kept free between two pieces; None for 2 mm, or 4 kerfs of a wide beam.
    wishes : for the cuts. names : of material and machine, for titles.
    priority : names of pieces, or of patterns for all of theirs, that lie on the first sheets.
    shared_cuts : whether pieces lie side to side along equal sides, which are cut once.

    Raises `InvalidValue` for copies that are no such number, for slots that are not wider than the
    kerf, and for pieces nearer to each other than the slots beside them; `InvalidState` for G-code
    of a machine that has no power to cut with, for two-sided sheets that are to be mirrored or to
    have closed slots, for closed slots along creases that are scored, and for a grain that the
    material does not have.
    """

    material: Material
    machine: Machine
    copies: int = 1
    registration: Registration | None = None
    formats: Sequence[SheetFormat] = USUAL
    page: bool = True
    stock_sheets: int | None = None
    grain_deg: float | None = None
    piece_gap_mm: float | None = None
    wishes: CutWishes = field(default_factory=CutWishes)
    names: tuple[str, str] = field(default=("", ""), compare=False)
    guide: bool = False
    priority: tuple[str, ...] = ()
    shared_cuts: bool = False

    def __post_init__(self) -> None:
        require_count("copies", self.copies, 1, "Ask for one copy or more.")
        if SheetFormat.GCODE in self.formats and self.machine.powers.cut_percent is None:
            raise InvalidState(
                "machine",
                "the machine has no powers.cut_percent, and G-code has to state powers",
                "Give cut_percent, perforate_percent, score_percent and engrave_percent in "
                "[powers] of a machine of your own.",
            )
        if self.grain_deg is not None and self.material.grain_deg is None:
            raise InvalidState(
                "cutter.grain_deg",
                f"grain_deg = {self.grain_deg:g}: the material has no grain to lie along",
                "Give grain_deg, 0.0 for along the bed's x axis, in a material of your own, or "
                "leave grain_deg of [cutter] out.",
            )
        self._require_possible_wishes()

    def _require_possible_wishes(self) -> None:
        """Raise `InvalidState` for wishes that contradict each other."""
        if self.registration is not None and (self.wishes.mirror or self.wishes.closed_slots):
            which = "mirror" if self.wishes.mirror else "closed_slots"
            raise InvalidState(
                "cutter",
                f"sheets that are two_sided cannot have {which} = true too",
                f"Leave out two_sided or {which}.",
            )
        if self.shared_cuts:
            self._require_shareable()
        scored = [key for key in ("mountain", "valley", "flat", "unassigned") if self._scored(key)]
        if self.wishes.closed_slots and scored:
            raise InvalidState(
                "cutter",
                f"closed_slots would cut whole creases through: {' and '.join(scored)} are scored",
                "Give them dashes in [perforation], or take another material.",
            )
        if self.wishes.closed_slots:
            require_wider(self.wishes.slot_mm, self.machine.beam)
        least = math.ceil(200 * self.slot_reach_mm) / 100
        if self.piece_gap_mm is not None and self.piece_gap_mm < least:
            raise InvalidValue(
                "cutter.piece_gap_mm",
                self.piece_gap_mm,
                f"be at least {least:g}, for the slots beside two pieces with bridges",
                "Leave it out, or lower slot_mm.",
            )

    def _require_shareable(self) -> None:
        """Raise `InvalidState` where pieces cannot have sides in common."""
        reasons = {
            "bridges would leave open what two pieces share": self.wishes.bridges > 0,
            "closed_slots wants no open cuts": self.wishes.closed_slots,
            "the beam is wider along an axis, and pieces that are turned need gaps of their own": (
                not self.machine.beam.is_round
            ),
        }
        for reason, given in reasons.items():
            if given:
                raise InvalidState("cutter", f"shared_cuts = true: {reason}", "Leave out one.")

    def _scored(self, key: str) -> bool:
        tables = (self.perforation, *self.perforation.bands)
        return any(isinstance(getattr(table, key, None), ScoreStyle) for table in tables)

    @property
    def margin_mm(self) -> float:
        """Kept free around the bed: its margin, and what is cut or marked beside pieces."""
        border = self.registration.border_mm if self.registration is not None else 0.0
        beside = border + self.machine.knife.offset_mm + self.slot_reach_mm
        return self.machine.margin_mm + beside

    @property
    def slot_reach_mm(self) -> float:
        """How far slots beside outlines that have bridges reach, 0 where there are none."""
        slotted = self.wishes.closed_slots and self.wishes.bridges > 0
        return SLOT_REACH * self.wishes.slot_mm if slotted else 0.0

    @property
    def gap_mm(self) -> float:
        """Kept free between two pieces on a sheet."""
        if self.piece_gap_mm is not None:
            return self.piece_gap_mm
        knife = self.machine.knife
        beside = knife.lead_in_mm + knife.offset_mm + 2 * self.slot_reach_mm
        return max(_GAP_MM, _GAP_KERFS * self.machine.beam.widest_mm) + beside

    @property
    def rotations_deg(self) -> tuple[float, ...] | None:
        """By which pieces are turned on the bed, in degrees, so that they keep the grain.

        The grain of the pattern, x where nothing else is said, comes to lie along that of the
        material; from there pieces turn as the material allows. Sheets are mirrored after that,
        where they are, so that it then lies along the mirrored grain. None for any angle.
        """
        turns, grain = self.material.rotations_deg, self.grain_deg
        if turns is None and grain is None:
            return None
        stock = self.material.grain_deg or 0.0
        along = (-stock if self.wishes.mirror else stock) - (grain or 0.0)
        return tuple((along + turn) % 360.0 for turn in turns or (0.0, 180.0))

    @property
    def split(self) -> SheetSplit:
        """How the pattern is cut into pieces."""
        return SheetSplit(
            margin_mm=self.margin_mm,
            mitre_mm=_CORNER_KERFS * self.machine.beam.widest_mm,
            tab_mm=max(self.material.tab_mm, _LEAST_TAB_MM),
            tabs=self.wishes.tabs,
            thickness_mm=self.material.thickness_mm,
            stitch_mm=self.wishes.stitch_mm,
            stitch_hole_mm=self.wishes.stitch_hole_mm,
            rotations_deg=self.rotations_deg,
        )

    @property
    def perforation(self) -> PerforationSettings:
        """How creases are cut."""
        scored = self.registration is not None
        dashed = self.wishes.closed_slots or any(kind in PROGRAMS for kind in self.formats)
        return perforation_for(self.machine, self.material, scored=scored, dashed=dashed)

    @property
    def speeds(self) -> Speeds:
        """How fast the machine cuts the material."""
        speeds, ratio = self.machine.speeds, self.material.cut_speed_ratio
        return speeds.model_copy(
            update={
                "cut_mm_s": speeds.cut_mm_s * ratio,
                "perforate_mm_s": speeds.perforate_mm_s * ratio,
            }
        )

    @property
    def drawing_style(self) -> DrawingStyle:
        """What the machine wants of its drawings."""
        machine = self.machine
        return DrawingStyle(
            machine.colours,
            machine.dxf_version,
            machine.stroke_mm,
            self.cut_settings,
            machine.s_max,
        )

    @property
    def cut_settings(self) -> dict[Operation, CutSetting]:
        """Speed and power of each operation in the material."""
        speeds, powers = self.speeds, self.machine.powers
        cut = CutSetting(speeds.cut_mm_s, powers.cut_percent)
        return {
            Operation.ENGRAVE: CutSetting(speeds.engrave_mm_s, powers.engrave_percent),
            Operation.MOUNTAIN: CutSetting(speeds.perforate_mm_s, self._crease_power("mountain")),
            Operation.VALLEY: CutSetting(speeds.perforate_mm_s, self._crease_power("valley")),
            Operation.RELIEF: cut,
            Operation.HOLE: cut,
            Operation.CUT: cut,
        }

    def _crease_power(self, letter: Literal["mountain", "valley"]) -> float | None:
        """Power for creases, in per cent; none where some are scored and others cut by dashes."""
        perforation, powers = self.perforation, self.machine.powers
        styles = [getattr(table, letter) for table in (perforation, *perforation.bands)]
        if letter == "valley":  # the layer of valleys has these too
            styles += [perforation.flat, perforation.unassigned]
        elsewhere = NoStyle | EngraveStyle | None
        scored = [isinstance(s, ScoreStyle) for s in styles if not isinstance(s, elsewhere)]
        if all(scored):
            return powers.score_percent
        return None if any(scored) else powers.perforate_percent
