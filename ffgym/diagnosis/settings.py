"""Thresholds of the diagnosis in one place, each with its unit and its reason.

A number that may change the answer of a diagnosis, or what is identified of friction, stands here, so that it can be
varied. Numbers of arithmetic (rounding, sizes of chunks in memory) stand beside their code.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

from ffgym.core.errors import check_choice


@dataclass(frozen=True, kw_only=True)
class SamplingSettings:
    """Rows and bands in which a log is compared."""

    same_period: float = 0.01
    """Relative difference of sample periods up to which recordings count as sampled alike."""
    trembling: float = 3.0
    """Half the band in which a reading may move while the motor stands, in standard deviations of its noise."""
    trembling_per_octave: int = 2
    """Widths of that band in an octave: so coarse that it is mostly the same in all logs of one machine."""
    tracker_gap: int = 5
    """Sample periods of the tracker over which its position is interpolated; chosen: a lost sample or some."""
    range_margin: float = 0.05
    """Share of its reach by which a joint that went beyond its range has room; chosen: a servo overshoots."""
    seen_band: float = 0.05
    """Share of the band that is taken to be seen at least, however high the low-pass."""
    values_per_block: int = 20
    """Independent values in a block, from which its noise is known to a sixth; fewer in one that would last too
    long."""
    fewest_values_per_block: int = 6
    """Independent values in a block at least."""
    longest_block: float = 0.1
    """Time [s] that a block should last at most; chosen: most of those between two reversals show none of them."""
    fewest_blocks: int = 8
    """Blocks below which quiet ones are not told from others."""
    motion_cutoff: float = 100.0
    """Low-pass of the motor angle before it is differentiated [Hz], and of all that friction is identified from. A
    reversal takes 7 to 30 ms in the records of table 6.1, which the thesis' 40 Hz smear: sigma_1 was then up to 3 %
    wrong on the built-in robot, 0.4 % at 100 Hz, in a study that is not stored."""
    cutoff: float = 40.0
    """Low-pass of what is compared [Hz]: above the resonances of industrial robots, 5 to 30 Hz, and thesis
    6.1.2."""
    motion_over_cutoff: float = 2.5
    """Cut-off of the motion over that of what is compared, at most; what is above shows in neither."""
    rows_of_short_log: int = 3000
    """Rows that all motions together shall have; chosen: 40 s at 25 Hz. A shorter log has them from a wider band,
    where what repeats with the motor's turns is seen best."""
    widest_cutoff: float = 0.38
    """Largest cut-off of a short log, as a share of the sample rate: below half of it, where filters still have
    room."""
    filter_half_length: float = 2.0
    """Half the length of the low-pass of what is compared, in periods of its cut-off; chosen: 50 ms at 40 Hz."""
    rows_per_period: int = 3
    """Rows kept per period of the cut-off; chosen: hardly more than what is needed to know the signal."""
    harmonics: float = 8.0
    """Cut-off over the bandwidth of the motion: friction that turns round with a slow motion has its seventh
    harmonic below."""
    lowest_cutoff: float = 5.0
    """Lowest cut-off that is chosen [Hz]; that of rigid-body identification
    (`identification.rigid_body.Filtering`)."""
    narrower: float = 2.0
    """Factor by which a band must be narrower than the usual one to be chosen."""
    motion_power: float = 0.99
    """Share of the power of a joint's speed below the bandwidth of its motion."""
    spectrum_segment: float = 20.0
    """Length [s] of the segments of which spectra are the mean: a resolution of 0.05 Hz."""
    above_noise: float = 1.5
    """RMS of what is above the narrow band, over that of noise, from which on something else than noise is
    there."""


@dataclass(frozen=True, kw_only=True)
class NoiseFloorSettings:
    """Noise floor: how much of a residual sensors and unknown motion explain."""

    torque_change_floor: float = 0.002
    """Part that is added to the noise of torques, as a share of the RMS of their changes, and to that of links and tool
    of what torques bend springs by: no model foretells torque better than to some per mille, however quiet the sensors;
    chosen."""
    draws: int = 2
    """Draws of the noise; an RMS over thousands of rows is known to some per cent from two."""
    torque_floor: float = 0.001
    """Least noise of a torque as a share of its RMS: no model foretells torque better than to a per mille;
    chosen."""
    part: float = 0.5
    """Length of the parts that are looked at [s]: with a window, frequencies from 4 Hz on are told apart."""
    lowest_periods: int = 2
    """Lowest frequency that a part shows, in periods of its length: the window spreads slower ones."""
    fewest_parts: int = 6
    """Parts below which nothing is said: of fewer, none is known to be quiet."""
    quiet_share: float = 0.25
    """Share of the parts that show noise alone."""
    frequencies_per_group: int = 4
    """Neighbouring frequencies whose energy is taken together; chosen: it is then known to a third in each part."""
    degrees_of_freedom: int = 6
    """Degrees of freedom of a group: a window makes neighbouring frequencies alike."""
    fewest_groups: int = 6
    """Groups of frequencies above the band that tell a part that falls from one that does not, at least."""
    flat_from: float = 0.2
    """Lowest frequency above the band, as a share of the sample rate, from which on noise of any colour is flat
    there."""
    steady: float = 2.0
    """Energy above the band over that of the quietest stretch up to which it is noise that is always there;
    chosen."""
    coloured_from: float = 1.0
    """Energy of the falling part at the lowest of those over that of the white one, from which on noise is
    coloured."""
    rounding_share: float = 1e-05
    """Share of a signal below which nothing of it is noise, but rounding; chosen: no sensor has so many steps."""
    beyond_falling: float = 1.3
    """Energy over that of noise that falls without end from which on what is left in the band is more than
    noise."""
    beyond_white: float = 1.1
    """The same over that of white noise from which on rare samples are tried for noise that goes on, falling, from
    above the band; chosen: what chance gives a dozen groups."""
    usual_corner: float = 0.3
    """Corner that is assumed then, as a share of the band; chosen: filters of drives."""
    half_band: float = 0.5
    """Share of both bands that is tried beside them: friction that half a band hides is as large as what a whole
    one does, to a factor of two; chosen."""
    reversal_time: float = 0.007
    """Time that a reversal takes in a motion without parts above 100 Hz [s]: samples so far apart tell nothing of
    it."""
    reversals_between_rows: float = 4.0
    """Sample periods, in reversals, from which on these lie between samples; chosen between two recordings:
    friction of the ball screw is named at 4 ms with the doubt alone, the late row of the KR300 at 100 ms without it
    alone."""
    rows_beside: int = 1
    """Rows on either side of one in which a motion between samples may show; chosen."""
    misread_draws: int = 4
    """Draws of the reading's noise; from one to the next it differs by a seventh of its mean, where that is
    large."""
    misfit_everywhere: float = 5.0
    """Usual misfit, in standard deviations of the noise, from which on a model misses everywhere; chosen."""
    outlier: float = 3.0
    """Usual misfits from which on a row stands out; of rows with a normal distribution 0.3 % do."""
    swing_left: float = 0.7
    """Energy of a motion's residual that is left without its swing, as a share of it, at most, if there was one;
    chosen on two drawn machines: motions that began with a swing left 0.2 to 0.6, those with other faults 0.8 and
    more."""


@dataclass(frozen=True, kw_only=True)
class PriorsSettings:
    """Prior knowledge of the numbers of the nominal model, as standard deviations."""

    late_rows: float = 0.05
    """Standard deviation of the time between torque and position of a row, in rows; chosen: columns that are said
    to be of one instant are read within a fifth of a row."""
    late_cycles: float = 0.25
    """Standard deviation of the times by which a servo's torque and the speeds that it knows are late, in its
    cycles; chosen: up to a cycle of either is usual."""
    friction_lag: float = 0.0002
    """Standard deviation of the time by which friction lags behind the speed beyond what bristles say [s]; chosen:
    lags that were measured are of some milliseconds in thick films, and of none in thin ones."""
    bound: float = 4.0
    """Standard deviations beyond which a calibration error is none: without a bound calibration swallows effects.
    Of the sixty numbers of a robot one lies beyond 3 in every seventh robot, beyond 4 in one of 260. A cause that is a
    number of the model must lie beyond it, too: where joints swing, slopes do not explain what it does."""
    share: float = 0.005
    """Default standard deviation of nominal numbers, relative: of robots that are calibrated one by one."""
    offset: float = 2.0
    """Torque offset over `share` times the Coulomb torque, standard deviation: 1 % of it for the default share;
    chosen."""
    open_friction: float = 0.3
    """Standard deviation from which on a level of friction is as open as its plausible change is large, 30 %."""
    tool_offset: float = 2e-05
    """Standard deviation of the tool offset, each axis [m]: that of a laser tracker (thesis 2.2.4)."""
    fitted_share: float = 0.1
    """Least standard deviation of fitted numbers, relative. An effect that is not in the model hides in its
    neighbours while they are fitted (load friction in a torque constant: 24 %, parameter files of Rhoban BAM), and
    must be let out again."""
    fit_resamples: int = 20
    """Bootstrap resamples of the fit: its standard deviations to some 15 %, which is enough where they are
    small."""
    fitted_friction: float = 0.5
    """Standard deviation of friction levels that were fitted to the very logs, relative: a loss that grows with
    load, or a viscous friction that bends, hides in them, and they must give way."""
    torque_constant: float = 0.1
    """Standard deviation of torque per current, relative: tolerance of magnets and current sensors. Masses that
    were fitted to the torque cannot tell it."""
    fitted_offset: float = 0.5
    """Standard deviation of torque offsets in Coulomb torques; as good as free, as in the fit."""
    joint_presliding: float = 0.0001
    """Coulomb torque over bristle stiffness behind the gearbox [rad]: presliding of robots is 20 to 200 microrad
    there."""
    warmer: float = 10.0
    """Change of temperature with which it is tried whether an effect depends on it [K]."""
    noisy_bias: float = 1.05
    """Energy of torque that is left beside a bias, over that without one, from which on the bias is of noise in the
    motion that was made up; chosen: real bias lessens it. Two laps of the ball screw come to 1.02, the KR300 of
    2020 to 1.4."""
    centres: int = 3
    """Times that bias and noise are taken anew about other numbers; chosen."""
    centred: float = 0.1
    """Largest change of a number from which on bias and noise are taken anew [standard deviations]; chosen: a
    smaller one changes neither."""
    loose: float = 0.02
    """Standard deviation of nominal numbers, relative, from which on they are fitted to a log before anything is
    looked for in it; chosen: slopes about described numbers hold over four of 0.5 %, not over one of 5 %."""


@dataclass(frozen=True, kw_only=True)
class ReplaySettings:
    """Replay of a machine along measured motions."""

    friction_step: float = 0.00025
    """Longest step of the fine replay [s]; chosen: that of the engine for the fastest friction of the built-in
    robots."""
    link_step: float = 0.0005
    """Longest step of what is not friction in the fine replay [s]; chosen: a quarter of what swings are followed
    with else; what it leaves of torque is a hundredth of the noise, that of arms that swing fast and are tracked
    well included."""
    sharpenings: int = 2
    """Steps of the iteration that undoes the low-pass of the motion; chosen: lags of friction are gone after two,
    and the noise of the angles grows to three times itself at the edge of the band at most."""
    servo_explains: float = 0.5
    """Share of the feedback torque's energy that the documented servo on the measured error foretells, by some
    factor, of the machine that has it; chosen: gains that are wrong leave most, set-points that lead by a row or
    two hardly any."""
    servo_leaves: float = 0.03
    """Share of that energy that it leaves at most with the gains that suit best; chosen: the documented servo leaves
    less than a thousandth in logs with noise, one with a speed loop of its own nine hundredths and more."""
    same_motion: float = 0.03
    """RMS angle of a motor [rad] by which a simulated motion may miss the measured one. Under the documented servo,
    faults of joints, drives and loads make it miss by a third of that at most; another servo by twice that or more,
    and reversals are some milliseconds off then."""
    low_speed: float = 0.01
    """Share of a joint's largest speed below which bristles decide the torque. On recorded robots of 300 kg, 0.02
    rad/s: there Coulomb and viscous friction miss the torque by five to ten times as much as above it."""
    stribeck_peak: float = 1e-06
    """Relative difference of breakaway and Coulomb torque from which on a description has a peak at low speed."""
    shortest_log: float = 2.0
    """Time [s] that all motions together must last: a block of a second to fit to, and another to judge by."""
    link_period: float = 0.004
    """Time between evaluations [s]; chosen: the usual control period, in which no pose changes by much."""
    bending_period: float = 0.016
    """Time between evaluations of what bending adds [s]; chosen: it is a correction, known to a hundredth so."""
    other_masses_period: float = 0.032
    """Time between evaluations of what bending adds with other masses [s]; chosen: it is the change of a
    correction."""
    spring_step: float = 0.002
    """Longest step of the springs [s]; chosen: 60 steps in a swing of 8 Hz, 12 at the cut-off of what is
    compared."""
    rarest_rows: float = 0.0125
    """Longest sample period [s] that shows how joints swing; chosen: what is compared ends at 16 Hz there."""
    pose_period: float = 0.008
    """Time between evaluations of what a step is made of [s]; chosen: on cubics between them, the torque that
    springs of the built-in robots carry is known to 2e-6 of itself, a hundredth of the noise of any log."""
    delay_period: float = 0.03
    """Time between evaluations of how late a method is [s]; chosen: poses hardly change in it."""
    largest_deflection: float = 1.0
    """Deflection [rad] from which on an arm is no longer where it was measured: a thousand times what gearboxes
    bend."""


@dataclass(frozen=True, kw_only=True)
class BlocksOfTimeSettings:
    """Blocks of time, the unit of resampling, and thinning of long logs."""

    length: float = 1.0
    """Length of a block [s], the unit of resampling and of what is left out; long against the low-pass, 50 ms, and
    against the swing of an arm, 0.3 s."""
    most: int = 240
    """Blocks at most, about: resamples of more say the same, and a session of an hour at 1 Hz has no block of a
    second."""
    coarse_period: float = 0.02
    """Time [s] of which a coarse row is the median; chosen: short beside planned motion, long beside noise of
    encoders."""
    resting: float = 0.02
    """Share of the top speed of a joint below which it rests, as the checks of quality have it."""
    top_speed: float = 0.999
    """Share of the rows that the top of a speed or an acceleration bounds: of an hour 4 s may be glitches."""
    low_speed: float = 0.1
    """Share of its top speed at which friction at low speed is half gone; chosen: a Stribeck speed is near it."""
    cell: float = 1.0
    """Length of a cell [s]; chosen: a block of the evidence."""
    rest: float = 0.1
    """Time [s] for which all joints rest where a cell is cut at rest; chosen: longer than joints that turn together
    are slow."""
    longest_pause: float = 3.0
    """Interval of the clock [s] as which longer ones count: a cell lies in it, and a night takes no more memory."""
    cell_rows: float = 0.5
    """Share of its rows that a cell has at least; one with fewer lies in a pause of the clock."""
    stretch: int = 10
    """Cells of a stretch: 10 s, as the motions of the protocol `diagnosis` last. Of longer ones there would be
    fewer, and fewer could be left out in turn; of shorter ones filters and settling take too much."""
    whole_stretches: float = 1.5
    """Lengths of a stretch up to which a recording is taken whole; what is left of it would be none."""
    spread_share: float = 0.5
    """Share of the stretches that are spread evenly over the log, one in each part of it; the others lie where most
    is told. Chosen: what changes in an hour is seen at some ten times."""
    moving_share: float = 0.25
    """Share of a stretch in which a joint moves, at least."""
    samples: int = 540000
    """Samples of all joints and recordings together: 90 s of six axes at 1 kHz, with which a diagnosis stays below
    3 GB."""
    rows: int = 270000
    """Rows that are compared, of all joints together: 360 s of six axes at 250 Hz, 450 s at 100 Hz. It is the one
    that counts for slow logs, of which each sample is a row."""


@dataclass(frozen=True, kw_only=True)
class ScreeningSettings:
    """Screening of candidates by their sensitivities."""

    periodic_from: float = 1.1
    """Energy over that of sensors' noise from which on something may have a period in it: with quiet sensors, a
    wave stands out long before it comes to what the floor allows a model to be wrong by."""
    spring_from: float = 3.0
    """Energy over that of noise from which on a joint's spring may be so wrong that slopes do not tell; chosen."""
    small_step: float = 0.3
    """Share of a practical step by which what swings is perturbed; chosen: a base of 30 Hz, faster than machines
    move."""
    step: float = 0.3
    """Step as a share of what is plausible; chosen: large against rounding, small against where effects bend."""
    width: float = 10.0
    """Standard deviation of a number in its practical steps: as good as free, but not without end."""
    surrogates: int = 60
    """Draws of noise; the largest score of any candidate in each gives the threshold."""
    ridge: float = 0.0001
    """Share of a column's energy that a linear fit pays for using it: numbers that cancel each other along a log,
    as the sine and cosine of a joint that hardly turns, are no start for a fit where an arm bends; chosen: 1 % of
    amplitude."""
    level: float = 0.999
    """Share of faultless logs whose largest score lies below the threshold: of a hundred none should be above."""


@dataclass(frozen=True, kw_only=True)
class EstimatorSettings:
    """Fits by Gauss-Newton in a trust region: steps, reaches and when they end."""

    reach: float = 3.0
    """Longest change of a free number in one step, in practical steps; chosen: an effect grows from nothing to what is
    plausible in one."""
    least_reach: float = 0.1
    """Reach below which a fit of free numbers has come to rest, in practical steps; a thirtieth of the first."""
    steps: int = 4
    """Gauss-Newton steps of causes at most; chosen: slopes about a linear fit lead near in two."""
    gain: float = 0.01
    """Relative gain of energy below which another step is not worth a replay."""
    rest: float = 0.02
    """Change of free numbers, in practical steps, below which such a step of causes is the last."""
    number_steps: int = 25
    """Steps of the numbers of a machine at most; a six-axis arm whose numbers are off by 5 % takes about ten."""
    number_reach: float = 0.5
    """Standard deviations by which a number of a machine moves in one step at most; chosen: at 1.5 an arm of six axes
    that swings came to rest beside its numbers."""
    number_least_reach: float = 0.05
    """Reach below which a fit of numbers has come to rest [standard deviations]; chosen: a tenth of the first."""
    number_gain: float = 0.005
    """Relative gain of a step of numbers below which further ones bring nothing, unless they go as far as they may."""
    promises: float = 0.7
    """Share of what slopes about the described numbers promise to leave that slopes about others must promise at most,
    if all that is left is to be due to numbers; chosen: a cause that is none of them changes it by some per cent."""
    bent: float = 0.1
    """Energy in units of the noise's, of the component that has most, by which the first replay of fitted numbers
    differs from what slopes say of it, from which on slopes do not do; chosen: chance comes to half."""
    model_steps: int = 2
    """Steps of causes and numbers of the extended model; the second changes what is left by less than a per cent."""
    passes: int = 2
    """Times that all numbers of a description are fitted and residuals then weighed anew, at each low-pass."""
    tuning_steps: int = 5
    """Gauss-Newton steps of all numbers of a description at most, in each pass."""
    spread: float = 2.0
    """Standard deviation of such a number, in plausible ranges of its effect, which are those of identified robots."""
    tuned_offset: float = 0.5
    """Standard deviation of a torque offset beside them, in Coulomb torques; chosen: as good as free."""
    tuned_place: float = 1e-3
    """Standard deviation of the tool's place in a motion beside them, each axis [m]; chosen: that of robots that nobody
    calibrated."""


@dataclass(frozen=True, kw_only=True)
class SearchSettings:
    """Search for causes: what is tried, kept and dropped."""

    most_causes: int = 8
    """Causes that are named at most; a model that lacks more is better identified anew."""
    tried: int = 3
    """Candidates that are fitted by replaying, in each round."""
    near_best: float = 0.5
    """Share of the best candidate's score from which on another is fitted, too."""
    same_target: float = 0.1
    """Share of what the best candidate changes that another must change too, to be an explanation of the same;
    others may be true beside it, and are looked at when it is adopted."""
    elsewhere: int = 2
    """Times that a round goes on with candidates of other joints, where the best is not adopted."""
    exchanges: int = 3
    """Times that a cause gives way to a rival that explains more beside the causes that came later; chosen: mostly
    none."""
    slack: float = 0.02
    """Share of the energy, or of what is removed of it if that is less, by which a hypothesis must beat another for
    each number that it has more."""
    needed: float = 0.05
    """Share of the energy that a cause must keep away beside the others, else it is dropped."""
    clearly_needed: float = 1.0
    """The same where others are fitted by slopes alone, from which on they are not fitted by replaying; chosen:
    slopes are that far off for none but springs that swing."""
    finer_from: float = 1.05
    """Energy left, in units of the noise's, from which on a fit may gain from being finer."""
    touched: float = 0.01
    """Share of a column's energy per row that counts, weighted by the noise, from which on it touches a
    component."""
    loudest_share: float = 0.1
    """Share of what is above the noise that a component must have to speak for all, and of its mean to be heard at
    all."""
    inexact_numbers: float = 0.01
    """Share of the energy that numbers within their calibration explain which they may leave; chosen: a tenth of
    the amplitude, of swings whose phase those numbers turn."""
    frequency_step: float = 0.05
    """Step of a frequency as a share of itself; a frequency is looked for before, and only refined here."""
    implausible: float = 1.0
    """Widths of its plausible range by which a size must lie beyond it to be held against a hypothesis: ranges are
    chosen, not measured, and robots differ."""
    unphysical: float = 10.0
    """The same from which on no machine has such a share; chosen: those of recorded machines reach two."""
    other_wave: float = 0.3
    """Relative difference of two frequencies from which on they are two waves; harmonics are further apart."""


@dataclass(frozen=True, kw_only=True)
class SignificanceSettings:
    """Evidence that a cause must have to be adopted."""

    at_range_end: float = 0.001
    """Share of its plausible range within which a shape is at the end of it."""
    seen_shape: float = 10.0
    """Energy of a tenth of a shape's range, in energies of the noise of a row, from which on the log says what it
    is."""
    explains: float = 0.25
    """Share of what is left above the noise, where it acts, that a cause of one joint must remove to be adopted.
    One of the machine as a whole explains all components by the same numbers, and each of them is a witness: of n,
    the share is less by the root of n."""
    floor: float = 0.05
    """Share of all energy where it acts, noise included, that must lie above the noise, and that a cause must
    remove."""
    together: float = 0.5
    """Share of what is above the noise in the component that they explain best, among those with much above it,
    that all causes together must remove, else none of them is one: something else is there, which each of them
    imitates a little."""
    inexact: float = 0.1
    """Share of what the causes before removed from a component that another one must remove beyond: no equation is
    exact, and what is left of a cause that was adopted in another form is no cause of its own. What may be left of
    one that is named."""
    quiet: float = 1.5
    """Energy in units of the noise's that clean logs may have in a component: causes may leave it, and none whose
    shape is at the end of its range, or whose sizes are not of note, is adopted for it."""
    leaks: float = 0.02
    """Share of what is still above the noise in the loudest component of a channel that a cause must remove beyond,
    in any of them: what ails one joint shows in others a little, through springs and calibration, until it is
    explained; chosen: a seventh of the amplitude."""
    holds: float = 0.25
    """Share of what a cause removes in a fit to all rows that it must remove from rows that it was not fitted to.
    Right ones of development exams hold nearly all of it; one that bends around what another equation leaves, next
    to nothing."""
    clear: float = 6.0
    """Held-out energy over the largest that chance reaches from which on a cause may stand below the noise floor:
    the floor allows for what may be there, and need not be. Of development exams, none of 200 clean logs comes to
    more with MOSTLY of what is there; right causes do with 7 and more."""
    mostly: float = 0.6
    """Share of all energy where it acts that a cause below the noise floor must remove: what is left there is no
    noise, but what else the model lacks, and a cause that removes less of it is a guess. Of development exams, a
    clean log comes to 0.45 and a wrong cause to 0.52, by friction that falls with speed where sensors are quiet."""
    clearer: float = 15.0
    """The same as CLEAR for a cause of one number, which has no shape to bend around what the model lacks: with
    that much, EXPLAINS of what is there is enough. A right cause of a development exam comes to 22 with 0.45 of
    what is there."""
    certain: float = 0.25
    """Share of the energy of noise that is not doubt of single rows from which on a cause may stand below the
    floor: what rows are doubted by may be there, and any cause would bend around it; chosen: three quarters of
    usual logs are."""
    sizeable: float = 0.02
    """Share of the plausible range of a size that one of a cause must have below the floor, and where clean logs are as
    loud: of less, any simulation has some, by its steps; chosen: servo gains that are a thousandth off stand out
    from logs without noise."""


@dataclass(frozen=True, kw_only=True)
class RivalsSettings:
    """Comparison of a cause with its rivals, and the session that separates them."""

    tied: float = 0.05
    """A rival ties if it is at least as good in this share of resamples."""
    alike: float = 0.02
    """Share of what is above the noise by which a rival with no more numbers must explain less, whatever the
    resamples say: no equation is exact, and one that is this near is not ruled out by what it leaves. Of a rival
    with as many numbers the best explanation shows how inexact equations are here: it need not leave more than that
    does above the noise."""
    unsure_floor: float = 0.05
    """Share of the energy of noise by which the floor itself may be off; chosen: two draws of it differ by some per
    cent."""
    instead: float = 0.5
    """Share of what a cause removes where it acts that a rival must remove there too; less explains something
    else."""
    near: float = 0.9
    """Share of what a cause removes where it acts from which on a rival that lost is compared once more beside the
    other causes: without them it may have been led astray."""
    resamples: int = 500
    """Resamples of blocks by which a rival ties or loses; a share of 5 % is then known to a per cent."""
    foreseen_dt: float = 0.004
    """Sample time of what is foreseen [s]; chosen: up to 25 Hz is enough to choose a motion by."""
    foreseen_width: float = 1.0
    """Standard deviation of a cause's own numbers, in practical steps (a third of what is plausible for a size);
    chosen: the logs that led to the causes know them better than that, but not in every regime."""
    log_ratio: float = 20.0
    """Log-likelihood ratio that a session should give; chosen: three times the logarithm of the number of effects
    and joints, so that half of the session still decides."""
    longest_session: float = 90.0
    """Longest motions of a session together [s]: those of the first recording of a machine."""


@dataclass(frozen=True, kw_only=True)
class VerdictSettings:
    """Verdict, and drifts over recordings."""

    named: float = 0.9
    """Share of the energy above the noise that causes must remove in each component to be named without reserve, or
    leave no more than QUIET."""
    each: float = 0.5
    """Share of what was left, where it acts, that each cause must remove to be named without reserve."""
    patterns: int = 3
    """Components of which the sentence says what is left there depends on; chosen: more are in the list of
    patterns."""
    as_much: float = 0.9
    """Share of what the strongest pattern of a component explains from which on another one stands beside it in the
    sentence; chosen: chance orders two that are so near."""
    stands_out: float = 0.5
    """Share of the torque's residual above noise that an effect must explain to be spoken of: what explains less
    than half is imitated by something else as often."""
    drift_recordings: int = 4
    """Recordings below which a change with the days is not told from chance."""
    drift_level: float = 0.01
    """Probability by chance below which a level changes with the days; a joint has two, and robots have few
    joints."""
    drift_size: float = 0.05
    """Least change of a level from the first to the last day, relative; chosen: friction of robots that nobody
    touched repeats to some per cent."""
    drift_days: float = 14.0
    """Days that recordings must span; chosen: what differs within some days is temperature and motion, not running
    in or wear."""
    drift_blocks: int = 8
    """Blocks of a recording below which errors are not known."""
    drift_holds: float = 0.2
    """The same without any one of the days: what one odd day makes is no change with the days."""


@dataclass(frozen=True, kw_only=True)
class IntervalsSettings:
    """Intervals of sizes."""

    folds: int = 3
    """Groups of motions that are left out in turn; each takes a fit, and a replay of all motions."""
    resamples: int = 200
    """Resamples of blocks; quantiles of 5 and 95 % are then known to a per cent or two."""
    widened: float = 1.5
    """Quantiles of resamples are this much further from a size: what neither rows nor calibration vary (equations
    that are not straight, few blocks) counts too."""
    inexact: float = 0.02
    """Share of a size that is open whatever the rows say, as the model around it is inexact: numbers of the nominal
    model are off by half a per cent each, and a fit stops when it would gain nothing. Of 90 sizes of development
    exams 74 % lay in what rows alone give, a fifth wider; 88 % lie in intervals with both constants."""


@dataclass(frozen=True, kw_only=True)
class PatternsSettings:
    """Patterns of what is left, and regimes of motion."""

    false_alarms: float = 0.01
    """Probability that noise alone gives any pattern in any channel."""
    least_share: float = 0.05
    """Least share of a component's residual that a pattern explains; less is not worth a word, however sure it
    is."""
    most: int = 4
    """Most patterns of one component."""
    cuts: int = 3
    """Ways of cutting the rows into halves in which ripple is looked for: a motor may be fast enough to show it in
    a few stretches alone, which may all come to lie in one half; chosen."""
    prior_rows: float = 3.0
    """Rows of zero that are added to the fit of each column, so that one seen in few rows says little; chosen: far
    less than a block has."""
    cells: int = 16
    """Cells of the angle in one cycle; a value at the edge of its cell then counts for 0.98 of itself."""
    fewest_periods: float = 1.5
    """Periods over the whole way of a motor that make a periodic function; with fewer it is any smooth function."""
    lowest_line: float = 1.0
    """Lowest line in time [Hz]; slower ones are rhythms of the motions."""
    block: int = 12
    """Rows that are one observation in a test; chosen: rows are a third of the period of the filter's cut-off
    apart, so that noise forgets within four of them, and a block shares little with the next."""
    chunk: int = 5
    """Blocks that are fitted or judged together, so that most have neighbours that are judged with them. At 125 rows a
    second half of one, short against motions, so that both halves see each regime."""
    passed: float = 0.9
    """Frequency up to which rows show a vibration, as a share of the cut-off of their filter."""
    slow: float = 0.1
    """Frequency up to which a change is slow, as a share of that up to which rows show a vibration; chosen: the
    planned motion and friction along it are below, most turns of a motor above."""
    fewest_blocks: int = 40
    """Least blocks of a channel that patterns are sought in; with fewer, no half could pass a test over a
    family."""
    most_rows: int = 400
    """Rows that are compared with each other; chosen: their pairs take a millisecond per shuffle."""
    draws: int = 60
    """Shuffles of the residual; chosen: mean and spread of their largest scores are then known to a tenth."""
    apart: int = 2
    """Blocks that are compared are so far apart; next to each other they share what the low-pass spreads."""
    rest: float = 0.05
    """Motor speed below which a motor stands [rad/s]; chosen: above what noise of a resolver of 16 bit makes of
    standstill, a sixth of the slowest motion of the protocols, a third of the Stribeck velocity of the thesis, and a
    jump that swings an arm by less than its friction."""
    bristles: float = 3.0
    """Travel within which bristles bend after a motor turned, in units of f_s / sigma_0: from -1 to 1, their
    deflection is then within 2 e^-3 = 10 % of where it goes."""
    reversal: float = 30.0
    """Travel up to which a motor counts as just turned, in the same unit; chosen: ten times presliding."""
    dwell: float = 0.25
    """Time from which a motor had stood before its move [s]; shorter stops are turns. Chosen: below the shortest
    rest of the protocols, 0.3 s, and above what slow sines take to turn."""
    slow_motion: float = 2.0
    """Motor speed up to which motion is slow, in Stribeck velocities: e^-4 = 2 % of the Stribeck peak is left
    there."""
    few: int = 20
    """Rows below which nothing is said about a regime; chosen: their RMS is off by a sixth at least (1 / sqrt(2
    n))."""


@dataclass(frozen=True, kw_only=True)
class FrictionFitSettings:
    """Identification of LuGre friction: rows that count, bounds and priors of its fits, and what counts as identified.

    Presliding lengths are f_s / sigma_0 and speeds those of the motor. The filter of motion and torque is
    `sampling.motion_cutoff`, and a motor stands below the speed `patterns.rest`.
    """

    gravity_passes: int = 2
    """Times that gravity is evaluated, the second time where the arm hangs in its springs; what a third would change is
    (gravity's stiffness / joint stiffness)^2 of it, 1e-5 on the built-in robot."""
    poses: int = 100
    """Poses of a record that the inertia of links is averaged over; a record moves about one place."""
    swing_decay: float = 100.0
    """Factor by which a swing must have died out."""
    speed_window: float = 0.1
    """Time over which speeds are averaged to compare them [s]: an encoder of 16 bit then resolves 1e-3 rad/s."""
    speed_drift: float = 0.05
    """Largest change of a constant speed, relative to it [1/s]. A sine is slower than that for a few percent of its
    period only, less than the shortest run."""
    least_drift: float = 0.02
    """Change of speed that counts as none however slow the motion is [rad/s^2]: what an encoder of 16 bit shows in
    windows of 0.1 s, doubled."""
    lowest_speed: float = 4e-3
    """Speed below which a joint runs at no constant speed [rad/s]: four times what 16 bit resolve in a window."""
    settling_travel: float = 8.0
    """Way that bristles take to settle, in presliding lengths: exp(-8) is 0.03 %; exp(-6), 0.2 %, is 0.5 % of v_s."""
    fewest_runs: int = 3
    """Runs at constant speed that a curve takes at least."""
    slow: float = 0.8
    """Speed in Stribeck velocities that data must have at or below: there the Stribeck part is half of what it is at
    rest. Between it and `fast` f_s, f_c and v_s cannot be told apart."""
    fast: float = 2.0
    """Speed in Stribeck velocities that data must have at or above: there the Stribeck part is 2 % of what it is at
    rest."""
    speed_ratio: float = 2.0
    """Ratio of the fastest to the slowest sliding speed from which viscous and Coulomb friction can be told apart."""
    least_stribeck_velocity: float = 0.01
    """Lower end of the range of Stribeck velocities that are looked at [rad/s]."""
    largest_stribeck_velocity: float = 10.0
    """Upper end of that range [rad/s]."""
    stribeck_velocities: int = 25
    """Stribeck velocities that are tried before the best is refined: two steps are a factor of 1.8."""
    slides: float = 3.0
    """Way between two reversals, in presliding lengths, from which on a joint slides: bristles are then bent to 95 %. A
    joint that other joints only shake goes a fraction of one; the shortest of table 6.1 goes ten."""
    fewest_reversals: int = 2
    """Reversals that a record must have: with one, an offset and a change of direction look alike."""
    constant_share: float = 0.2
    """Share of the time at constant speed from which a record is one of constant speeds: a sine has less than 0.02."""
    samples_per_period: float = 12.0
    """Samples in a period of the filter's cut-off that are kept: with six, a speed that runs straight between them
    costs 0.2 % of sigma_1."""
    same_period: float = 1e-3
    """Relative difference of sample periods that does not count: a thousandth of a row for each row."""
    rest_time: float = 0.1
    """Time from which a joint that does not move rests [s]; reversals are shorter."""
    forgetting_travel: float = 10.0
    """Way after which bristles have forgotten how they began, in presliding lengths."""
    least_presliding: float = 1e-5
    """Lower bound of the presliding length f_c / sigma_0 [rad]."""
    largest_presliding: float = 1.0
    """Upper bound of that length [rad]."""
    least_damping_speed: float = 1e-2
    """Lower bound of f_c / sigma_1 [rad/s]."""
    largest_damping_speed: float = 1e3
    """Upper bound of that speed [rad/s]."""
    inertia_error: float = 0.5
    """Largest relative error of the inertia that is allowed for: thesis 6.1.2 estimates up to 5 %, but descriptions
    give links within 30 % and rotors within a factor of two (docs/robots). A narrower bound makes bristles absorb the
    rest."""
    link_error: float = 0.2
    """Standard deviation of what the links' relative error differs from that of the whole inertia: descriptions give
    links within 30 %, rotors within a factor of two, and both errors are often one (docs/robots)."""
    spring_error: float = 0.3
    """Standard deviation of the relative error of a joint stiffness, as descriptions give it (docs/robots)."""
    lag: float = 0.5
    """Standard deviation of the time by which friction follows the motion, in rows of the record: when within a row
    bristles move is not known better, and a simulated plant's lag by a step. Its bound is one row."""
    delay: float = 5e-3
    """Standard deviation of the time by which a torque acts later than its record says [s]: headers say when a torque
    acts, but drives filter it by milliseconds."""
    longest_delay: float = 10e-3
    """Bound of that time [s]: a few periods of a controller."""
    misfit: float = 0.05
    """Error of a friction model before it is known, as a share of the Coulomb torque; weighs the priors of a first
    fit."""
    starts: int = 48
    """Random starts that are simulated, all at once."""
    refined_starts: int = 3
    """The best of them that are refined."""
    near_bound: float = 0.99
    """Share of a bound from which on a fit ends at it: the solver stays inside."""
    surrogate_steps: int = 8
    """Steps of surrogate data between two rows that are kept, so that their bristles know no step."""
    noisy_copies: int = 8
    """Surrogate records behind the bias of measured speeds; eight average its scatter to a third."""
    block: float = 0.5
    """Duration of a block that is resampled [s]: long against the filter's memory of 25 ms, some of them in each
    record."""
    fewest_blocks: int = 8
    """Blocks that an interval takes at least; of fewer, resamples say little."""
    least_ratio: float = 0.01
    """Smallest share of its estimate that a resampled static parameter counts as: one that ends at zero, where its
    logarithm is not finite, is far outside of what one Gauss-Newton step can follow. Chosen."""
    first_resamples: int = 20
    """Resamples of the first of both fits of a joint, which are only to tell what is identified."""
    matters: float = 0.1
    """Share of the Coulomb torque below which a viscous torque at the fastest speed does not matter."""
    widened: float = 1.1
    """Ends of an interval are this much further from the estimate than quantiles of resamples, for errors that no
    resample varies. Calibrated by simulation: 90 % intervals of 24 parameters of four joints held the truth in 87 % of
    50 repetitions without it, in 90 % with it; docs/identification.md has further repetitions."""
    wide: float = 0.5
    """Half width of an interval, relative to the value, from which it counts as wide."""


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Thresholds of a diagnosis by subject."""

    sampling: SamplingSettings = field(default_factory=SamplingSettings)
    noise: NoiseFloorSettings = field(default_factory=NoiseFloorSettings)
    prior: PriorsSettings = field(default_factory=PriorsSettings)
    replay: ReplaySettings = field(default_factory=ReplaySettings)
    blocks: BlocksOfTimeSettings = field(default_factory=BlocksOfTimeSettings)
    screening: ScreeningSettings = field(default_factory=ScreeningSettings)
    estimator: EstimatorSettings = field(default_factory=EstimatorSettings)
    search: SearchSettings = field(default_factory=SearchSettings)
    significance: SignificanceSettings = field(default_factory=SignificanceSettings)
    rivals: RivalsSettings = field(default_factory=RivalsSettings)
    verdict: VerdictSettings = field(default_factory=VerdictSettings)
    intervals: IntervalsSettings = field(default_factory=IntervalsSettings)
    patterns: PatternsSettings = field(default_factory=PatternsSettings)
    friction: FrictionFitSettings = field(default_factory=FrictionFitSettings)


_DEFAULT = Settings()

_CURRENT: ContextVar[Settings] = ContextVar("settings of the diagnosis", default=_DEFAULT)


def settings() -> Settings:
    """Return the settings that hold here: the defaults, unless `use_settings` says otherwise."""
    return _CURRENT.get()


@contextmanager
def use_settings(changes: Mapping[str, float]) -> Iterator[Settings]:
    """Diagnose with some settings changed, inside a `with` block, in this thread and process.

    Args:
        changes: new values by name, e.g. `{"search.near_best": 0.25}`.

    Raises:
        FFGymError: if a name is unknown.
    """
    changed = settings()
    for name, value in changes.items():
        check_choice("setting of the diagnosis", name, list(setting_values(changed)))
        group, own = name.split(".")
        changed = replace(changed, **{group: replace(getattr(changed, group), **{own: value})})
    token = _CURRENT.set(changed)
    try:
        yield changed
    finally:
        _CURRENT.reset(token)


class _ReadGroup:
    """A group of settings that adds the names that are read to a set."""

    def __init__(self, group: Any, prefix: str, read: set[str]) -> None:
        self._group, self._prefix, self._read = group, prefix, read

    def __getattr__(self, name: str) -> Any:
        self._read.add(f"{self._prefix}.{name}")
        return getattr(self._group, name)


@contextmanager
def record_reads() -> Iterator[set[str]]:
    """Collect the names of the settings that are read inside a `with` block; the others cannot change its outcome.

    Settings that are read when modules are imported, as defaults of arguments, are not seen.
    """
    now, read = settings(), set[str]()
    groups = {group.name: _ReadGroup(getattr(now, group.name), group.name, read) for group in fields(now)}
    token = _CURRENT.set(replace(now, **groups))  # type: ignore[arg-type]  # a group that tells what is read of it
    try:
        yield read
    finally:
        _CURRENT.reset(token)


def setting_values(of: Settings | None = None) -> dict[str, float]:
    """Return all settings by name, e.g. `search.near_best`."""
    groups = asdict(of or settings())
    return {f"{group}.{name}": value for group, own in groups.items() for name, value in own.items()}
