"""Every word on the page, in one place, so that it can be put into another language."""

TITLE = "footscan"

TAB_PATIENT, TAB_SCAN, TAB_INSPECT, TAB_CALIBRATE, TAB_SYSTEM = "Patient", "Scan", "Inspect", "Calibrate", "System"
TAB_LAST = "Last"

# Frame
STOP = "STOP"
STOP_HINT = "Lasers and motor off, now; what was captured is kept. It is no emergency stop. Key: X"
STOP_HOTKEY_LABEL = "Stop lasers and motor"
STOPPED_BY = "stopped on the page"
LASER_ON = "LASER ON: {lasers}"
TOES, MEASURED_RIM = "toes", "measured up to here"
ARMED = "ARMED"
RESET = "I have looked: reset"
RESET_HINT = "After a fault or an emergency stop, once the machine was looked at"
NO_CALIBRATION = "NO CALIBRATION"
CALIBRATION_AGE = "calibrated {days} days ago"
CALIBRATION_TODAY = "calibrated today"
CALIBRATION_INVALID = "CALIBRATION NOT VALID"
CALIBRATION_BAD = "The calibration is not valid: {why}. Renew or check it (Calibrate tab, or footscan calibration)."
CALIBRATION_DOUBT = "see Calibrate"
CALIBRATION_OLD = "CALIBRATION OLD ({days} days)"
CALIBRATION_UNDATED = "simulated calibration"
STARTING = "<b>footscan is starting</b>: the machine and the records are being opened ..."
OPENING = "<b>The machine is being opened</b> ..."
NOT_OPENED = "footscan could not be started"
NOT_OPENED_NEXT = "footscan has switched nothing on. Mend this, start footscan again, and load this page anew."
STILL_OPENING = "The machine is still being opened; a moment, please."
CLOSING = "footscan is being closed"
DISK_FREE = "{gigabytes:.0f} GB of disk free"
SIMULATED = "SIMULATED MACHINE"
HEAD_AT = "head {degrees:.0f}°"
HEAD_UNKNOWN = "head not homed"
YOU_CONTROL = "You control the machine."
YOU_WATCH = "You only watch: another browser controls the machine."
NOBODY_CONTROLS = "Nobody controls the machine."
TAKE_OVER = "Ask for control"
TAKE_OVER_TITLE = "Another browser asks for control"
TAKE_OVER_BODY = "Give it away? Without an answer it goes over after {seconds:.0f} s, unless the machine is busy."
TAKE_OVER_ASKED = "Asked. The other browser answers, or control comes to you after {seconds:.0f} s."
TAKE_OVER_REFUSED = "The other browser keeps control."
TAKE_OVER_BUSY = "While the machine is busy, control goes over only when the other browser agrees."
GIVE, KEEP = "Give control", "Keep control"
REFUSED_VALUE = "This value is not allowed and was not taken."
ONLY_WATCHING = "You only watch. Ask for control first."

# Camera
CAMERA = "Camera"
PICTURE = "Picture"
THRESHOLD = "Threshold"
THRESHOLD_HINT = "Grey value above which a pixel counts as laser light"
AUTOMATIC = "Automatic"
AUTOMATIC_HINT = "One threshold per scan, found where the tail of the background ends"
AUTOMATIC_VALUE = "automatic: <b>{value}</b> &nbsp; in use: <b>{used}</b> &nbsp; {points} stripe points"
ROW = "Row"
ROW_HINT = "The row of the picture whose brightness is drawn"
EXPOSURE = "Exposure and profile"
EXPOSURE_TITLE = "Brightness of all pixels (log10 of count)"
PROFILE_TITLE = "Brightness along the row"
SHINE = "Hold for laser light"
SHINE_HINT = "After Check: the laser shines as long as you hold the button down"
SHINE_LASER = "Laser"
LASERS = ("Right", "Left")
NO_LIGHT = "No laser is on: the picture stays grey. After Check, hold the button below for light."
CHOSEN = "{what}: {chosen}"

# Patient
OPERATOR = "Operator"
OPERATOR_HINT = "Your name; it is kept with every scan"
FIND = "Find patient"
FIND_HINT = "Part of the name, the own number or the birth date; accents do not matter"
FOUND = "Found"
NOBODY_FOUND = "(nobody; enter a new patient below)"
CHOOSE = "Take this patient"
NEW_PATIENT = "New patient"
NAME, BORN, NUMBER = "Name", "Born", "Own number"
BORN_HINT = "As year-month-day, such as 1962-03-31; may stay empty"
NUMBER_HINT = "The clinic's number of the patient; may stay empty"
ENTER = "Enter and take this patient"
PATIENT_NONE = "<b>No patient chosen.</b> Find one by typing, or enter a new one."
PATIENT_IS = "<b>{name}</b>{born}{number}"
PATIENT_EMPTY = "No visit yet. Next: the Scan tab."
ENTERED = "Patient entered"
NAMESAKE_TITLE = "Is it the same person?"
NAMESAKE_YES = "Another person: enter all the same"
NAMESAKE_NO = "Same person: do not enter"
NO_OPERATOR = "Type your name as operator first; it is kept with every scan."
VISITS_HEAD = "<tr><th>Take</th><th>Day</th><th>Foot</th><th>Load</th><th>Verdict</th><th></th></tr>"
IN_USE = "in use"
EARLIER_TITLE = "Said at an earlier visit. Does it hold today?"
EARLIER_SCANNED = "scanned {how}"
EARLIER_HOLDS, EARLIER_NOT = "It holds today", "It does not hold"
EARLIER_HOLDS_HINT = "Declared for today with your name; load and skin are chosen for the next scan"
EARLIER_NOT_HINT = "Nothing is declared; say below what is different today"
EARLIER_OPEN = "Said at an earlier visit and not confirmed for today: look at the Patient tab."
EARLIER_DONE = "Confirmed for today"
DECLARE = "What is special about a foot today"
DECLARE_PARTS = {
    "toe_1": "Big toe is missing",
    "toe_2": "Toe 2 is missing",
    "toe_3": "Toe 3 is missing",
    "toe_4": "Toe 4 is missing",
    "toe_5": "Little toe is missing",
    "ray_1": "First ray is missing",
    "ray_5": "Fifth ray is missing",
    "forefoot": "Forefoot is missing",
}
DECLARE_PART_HINT = (
    "What is missing is not looked for, and measurements that need it say so. A ray is a toe with its part of the ball"
)
DRESSINGS, DRESSINGS_HINT = "Dressings", "What covers the skin and where; empty when nothing does"
DEFORMITY, DEFORMITY_HINT = "Deformity", "As the clinician declares it, such as: hallux valgus, hammer toe 2"
NOT_SCANNED, NOT_SCANNED_HINT = (
    "Not scanned because",
    "Why this foot is left out today; else empty",
)
DECLARE_GO = "Declare it"
DECLARE_GO_HINT = "Kept with your name for today's visit; takes it changes are measured again"
DECLARED, DECLARED_WORDS = "Declared", "Of the {side} foot: {facts}."
DECLARED_NOTHING = "nothing special"
CORRECT = "Put a take right"
CORRECT_NONE = "(no take yet)"
CORRECT_SAME = "as it is"
CORRECT_HINT = "Choose only what was wrong; the recording itself stays as it is"
CORRECT_PATIENT = "Belongs to #"
CORRECT_PATIENT_HINT = "The number behind # in the list of found patients; empty when the patient was right"
CORRECT_NOBODY = "There is no patient #{number}. Find the right one above: the number stands behind #."
CORRECT_MOVE_TITLE = "Is it this person's foot?"
CORRECT_MOVE = "Take {take} goes to **{patient}**."
CORRECT_MOVE_YES, CORRECT_MOVE_NO = "Yes, move it", "No"
CORRECT_REASON = "Reason"
CORRECT_REASON_HINT = "A reason is needed; it is kept with your name"
CORRECT_GO = "Put it right"
CORRECT_GO_HINT = "What no longer fits is measured again; earlier results stay"
CORRECTED, CORRECTED_WORDS = "Put right", "Take {take} is now filed for {patient}: {side} foot, {load}."
HISTORY = "What was done, by whom and why"
HISTORY_OF = {"patient": "patient", "side": "foot", "load": "load", "surface": "skin", "in_use": "in use"}
YES, NO = "yes", "no"

# Scan
FOR_PATIENT = "Scan for <b>{name}</b>"
NEXT_FOOT = "Next: the {side} foot."
BOTH_DONE = "Both feet are done for today. Look at them (Inspect tab), repeat one, or take the next patient."
DECIDE = "Look at the {side} foot, and say below what becomes of this scan."
NO_PATIENT_SCAN = "Choose a patient in the Patient tab first."
SIDE, LOAD, SURFACE, PROFILE = "Foot", "Load", "Skin", "Density"
SIDE_HINT = "Which foot stands on the board"
LOAD_HINT = "How the person stands or sits"
SURFACE_HINT = "What covers the skin"
PROFILE_HINT = "How densely the foot is scanned"
WEDGE_FOLD = "Heel on a wedge"
WEDGE, WEDGE_HINT = "Wedge (mm)", "Height of the wedge's top under the middle of the heel; 0 when the foot stands flat"
WEDGE_WORDS = "For lasts with a high heel: the wedge's thin edge lies under the ball, ball and toes stand on the board."
ON_WEDGE = "on a wedge of {height:g} mm"
LOADS = {"unknown": "not said", "unloaded": "unloaded", "seated": "seated", "bipedal": "standing on both feet",
         "single_leg": "standing on this leg"}  # fmt: skip
SURFACES = {"unknown": "not said", "bare": "bare", "sock": "sock", "bandage": "bandage", "dressing": "dressing"}
SIDES = {"left": "left", "right": "right"}
CHECK, START = "1  Check", "2  Start"
CHECK_HINT = "Homes the head, tries lasers and motor, looks where the foot stands"
START_HINT = "Countdown, then the scan"
CHECK_FIRST = "Check first."
CHECK_AGAIN = "The machine was stopped since the check. Check again."
CHECK_GOOD = "Checked: nothing stands in the way. Start when the person stands still."
CHECK_REMARKS = "Checked, with remarks:"
CHECK_BAD = "Cannot scan yet:"
ARM_TITLE = "Look at the person first"
ARM_QUESTION = "Is nobody's face at beam height, and may the lasers and the motor be switched on?"
ARM_YES, ARM_NO = "Yes, nobody's face is there", "No"
STAND_STILL = "STAND STILL: {seconds:.0f}"
REMAINING = "{percent:.0f} %, {seconds:.0f} s to go, {frames} pictures"
PROCESSING = "{what}: {done} of {total}"
STOPS = "{what}: {percent:.0f} % of the stops"
SCAN_STOPPED = "Scan stopped"
SCAN_KEPT = "{why} What was captured lies in {folder}. Next: check again, then start again."
BUSY = "The machine is busy. Wait, or press STOP."
PLACEMENT_HINT = "Toes towards the camera (arrow), middle of the foot on the cross."

# Result
KEPT_SCANS = "Scans that were never filed"
KEPT_WORDS = "Scans that were broken off or not filed are kept. Choose the patient, then the scan."
KEPT, KEPT_NONE, KEPT_FILE = "Scan", "(none)", "Measure and file it"
KEPT_FILE_HINT = "For the chosen patient, with the load and skin chosen above; side as it was scanned"
BROKEN_OFF, PICTURES = "broken off", "pictures"
RESULT_NONE = "No result yet."
RESULT_OF = "{side} foot, take {number}"
ACCEPT, REMARK, REPEAT, REPROCESS = "Accept", "Use with remark", "Repeat", "Measure again"
ACCEPT_HINT = "Mark this take as the one to work with"
DECIDE_ELSE = "Or"
DECIDE_ELSE_HINT = (
    "Use with remark: the take to work with, your remark is kept with your name. Repeat: it is kept but not used; scan "
    "this foot again. Measure again: with the threshold on the left, without the patient; the earlier result is kept"
)
REMARK_LABEL = "Remark"
REMARK_LABEL_HINT = "Why it is used although it is not quite right, or why it is repeated"
REMARK_NEEDED = "Type a remark first: it says why."
DECISION = "Decision"
AGREEMENT = "Lasers agree within {median:.2f} mm (zone {zone}, the largest)"
COVERAGE = "Skin seen {seen:.0%}, bridged {bridged:.0%}, assumed {assumed:.0%}"
REFUSED_FOOT = "No foot could be measured: {why}"
ACCEPTED, REMARKED, REPEATED = "Accepted", "Kept with your remark", "Marked to be repeated"
VERDICTS = {"undecided": "undecided", "accepted": "accepted", "with_remark": "with remark", "repeat": "repeat"}

# Inspect
INSPECT_NONE = "No foot to look at yet. Choose a patient with a scan, or scan one."
TAKE = "Take"
SHOW = "Show"
SHOW_HINT = "Shaded; by where the skin comes from; or by how far the measured points lie from the surface"
OTHER_FOOT_HINT = "The other side of the same patient, for comparison"
OTHER_FOOT_NONE = "The other foot of this patient was not measured yet: scan it in the Scan tab."
MEASUREMENTS = "Measurements"
SHOW_KINDS = ("Shaded", "Seen / assumed", "Distance to points")
OTHER_FOOT = "Other foot beside it"
SECTION = "Section"
SECTION_SHARE = "Place (%)"
SECTION_SHARE_HINT = "Of the foot's length, from the heel"
SECTION_TURN = "Turn (°)"
SECTION_TURN_HINT = "Around the vertical; 0 cuts across the foot"
SECTION_TILT = "Tilt (°)"
SECTION_TILT_HINT = "0 is upright, 90 is level"
SECTION_TABLE = (
    "Area {area:.1f} cm² · perimeter {perimeter:.1f} mm · tape girth {tape:.1f} mm · "
    "width {width:.1f} mm · height {height:.1f} mm{unseen}"
)
SECTION_UNSEEN = " · {share:.0%} of the tape runs on skin that was not seen"
SECTION_MISSES = "The plane does not meet the foot."
SMOOTHING = "Filter and smooth (on a copy)"
SMOOTHING_WORDS = (
    "Shows what filtering points and smoothing the surface would change. What was measured stays as it is."
)
FILTER = "Filter points (0 to 1)"
FILTER_HINT = "0 leaves the points where they are, 1 moves them on to the plane of their neighbours"
SMOOTH = "Smooth over (mm)"
SMOOTH_HINT = "0 is off; features of this size lose half their height"
SMOOTH_GO = "Try it"
SMOOTH_GO_HINT = "Measures the foot again with both; takes a few seconds"
SMOOTH_NOTHING = "Both are 0, which changes nothing. Move a slider first."
SMOOTH_TRIED = "Shown: filter {filter:g}, smoothed over {smooth:g} mm"
SMOOTH_BACK = "Back to the foot as measured"
SMOOTH_BACK_HINT = "The copy is thrown away"
PRICE_HEAD = "<tr><th>What</th><th>Before</th><th>After</th><th>Change</th></tr>"
DOWNLOADS = "Downloads of the chosen take"
DOWNLOAD_TABLE = "Table (CSV)"
DOWNLOAD_NAMES = {
    "Surface": {"STL": "surface.stl", "PLY": "surface.ply", "Picture": "report.png"},
    "Values": {DOWNLOAD_TABLE: "measurements.csv", "JSON": "measurements.json"},
    "Sections": {"Sections (CSV)": "sections.csv"},
}
DOWNLOAD_HINTS = {
    "Surface": "The skin as measured, in mm: STL for milling and printing, PLY with colours; a page of pictures",
    "Values": "All measurements with intervals, marks and definitions: for a spreadsheet, or for programs",
    "Sections": "Cuts across the foot, one every 5 % of its length, for a spreadsheet",
}
LOOK = "Look from"
LOOK_HINT = (
    "Turns the 3-D view; drag it with the mouse to turn, scroll to come nearer, drag with the right button to move"
)
LOOK_FROM = {"Start": (0.30, -0.42, 0.30), "Top": (-0.01, 0.0, 0.62), "‹ Left": (0.0, 0.52, 0.09),
             "Right ›": (0.0, -0.52, 0.09), "Front": (0.55, 0.0, 0.12), "Back": (-0.55, 0.0, 0.12)}  # fmt: skip
WAYS = (("toes", "heel"), ("inner side", "outer side"), ("up", "sole"))
MEASURE_HEAD = "<tr><th>What</th><th>Value</th><th>Interval</th><th></th></tr>"
COMPARE_HEAD = "<tr><th>What</th><th>Left</th><th>Right</th><th>Difference</th></tr>"
COMPARE_NOTE = "Difference: right less left."
COMPARE_NONE = "none"
COMPARE_SECTION = "<b>{side}</b> ({line}): "
COMPARE_LINES = ("solid", "dashed")
MEASURE_NONE = "could not be measured"
MEASURE_MARKS = "⚠ not reliable, ◆ unusual: point at the mark for the reason, at a name for its definition."
LEGEND_ORIGIN = (("#e0a080", "seen"), ("#e8c020", "bridged"), ("#8090a0", "assumed"))
LEGEND_RESIDUAL = (("#2060ff", "0 mm"), ("#30c060", "0.2 mm"), ("#ff3020", "0.4 mm or more"), ("#8090a0", "not seen"))

# Calibrate
CALIBRATE_IN_FORCE = "<b>In force:</b>"
CALIBRATE_MADE = "calibration of {machine}, made {day}"
CALIBRATE_RECORD = "Record the calibration board"
CALIBRATE_INTRO = (
    "Clear the footboard: nothing may stand on it. Have the printed board at hand. "
    "The head then looks at the bare footboard and at four or more placements of the board."
)
CALIBRATE_BEGIN = "1  The footboard is bare: begin"
CALIBRATE_BEGIN_HINT = "Homes the head and looks at the bare footboard"
CALIBRATE_BARE = "The footboard is bare and the laser light falls on nothing else."
CALIBRATE_ADVICE = "<b>Placement {number}:</b> place the board {placed}. Then step back."
CALIBRATE_SIMULATED = "The simulated machine places it by itself."
CALIBRATE_PLACE = "2  The board stands: record it"
CALIBRATE_PLACE_HINT = "The head stops all around the board; the first board is also passed in motion"
CALIBRATE_STANDS = "The board stands where the advice says and does not move."
CALIBRATE_YES = "Yes, go"
CALIBRATE_FINISH = "3  Enough: compute"
CALIBRATE_PARKED = "head parked, motor and lasers off: place the board"
CALIBRATE_RECORDED = "<b>What was recorded last:</b>"
CALIBRATE_FINISH_HINT = "From four good placements on; the calibration in force stays until you accept the new one"
CALIBRATE_ENOUGH = "That is enough: compute now, or add another placement."
BOARD_PRINT = "Print the board (PDF)"
BOARD_PRINT_HINT = "On A4 landscape at 100 %, no fitting to the page; glue it on a stiff flat plate"
BOARD_FILE = "calibration-board.pdf"
BOARD_WORDS = (
    "Measure the printed board with a calliper, along a row and along a column: all squares, without the white border. "
    "<b>Every later length rests on it.</b>"
)
BOARD_AFTERWARDS = (
    "The lengths go into the fields {row} and {column} at the top of this tab; then compute again from this recording."
)
BOARD_ROW, BOARD_COLUMN = "Board row (mm)", "Board column (mm)"
BOARD_HINT = (
    "Nominally {nominal:g} mm; enter what the calliper says, 0 when it was not measured. "
    "Without both lengths the scale is not verified."
)
BOARD_BOTH = "One length of the board was given: measure along a row and along a column, or leave both at 0."
CALIBRATE_ABANDON = "Give up this recording"
CALIBRATE_ABANDON_HINT = "Closes it; its pictures stay on the disk, the calibration in force stays too"
CALIBRATE_ABANDON_SURE = "The recording is closed and not used. Begin anew from the bare footboard afterwards."
CALIBRATE_STOPPED = "Stopped"
CALIBRATE_STOPPED_NEXT = "{why} What was recorded is kept. Record this placement again, or give the recording up."
CALIBRATE_ABANDONED = "Recording given up"
CALIBRATE_AGAIN = "Compute from an earlier recording"
CALIBRATE_NONE = "(no finished recording yet)"
CALIBRATE_RECORDING = "Recording"
CALIBRATE_GO = "Compute"
CALIBRATE_HINT = "The calibration in force stays until you accept the new one"
CALIBRATE_RESULT = "New calibration"
CALIBRATE_EMPTY = "Nothing computed yet. Record the board above, or compute from an earlier recording."
CALIBRATE_NEW = "Computed, not in force yet:"
CALIBRATE_ACCEPT, CALIBRATE_KEEP = "Put the new one in force", "Keep the old one"
CALIBRATE_ACCEPT_HINT = "From now on scans use it; the machine is opened again and homes anew"
CALIBRATE_KEEP_HINT = "The new one is thrown away, its recording stays"
CALIBRATE_ACCEPT_SURE = "From the next scan on the new calibration is used. The old one is kept in the history."
CALIBRATE_REFUSED = "Refused, the calibration in force stays: {why}"
CALIBRATE_DONE = "The new calibration is in force."
CALIBRATE_KEPT = "The old calibration stays in force."
CALIBRATION_OPEN = "A calibration recording is open. Finish it or give it up in the Calibrate tab first."

# System
DEVICES = "Devices"
LOG = "Log"
EXAMINE = "Examine all devices"
EXAMINE_HINT = "Looks at camera, encoder, outputs, disk and calibration, and says in words what is wrong"
EXAMINED = {"io": "outputs"}
NOT_OPENED_AGAIN = "{why} The machine stays closed, nothing is on. Mend this, then examine again: that opens it."
MACHINE_CLOSED = "the machine is closed: mend what is wrong, then Examine all devices (System tab) opens it again"
EXAMINE_SURE = "The machine is closed for it and opened again; the head must find its home again afterwards."
DRILL = "Drill"
DRILL_WORDS = "Breaks a simulated copy of this machine in every known way, in a folder of its own."
DRILL_MACHINE = "Break the machine"
DRILL_MACHINE_HINT = "How long lasers and motor stay on after each fault; takes a minute or more"
DRILL_REAL = "The drill breaks simulated machines only; run footscan drill on another computer."
DRILL_RECORDS = "Kill {kills} programs while they store"
DRILL_RECORDS_HINT = "Looks whether anything that was acknowledged is gone"
DRILL_RECORDS_DONE = "{kills} kills, {acknowledged} acknowledged calls:"
DRILL_NO_PROBLEMS = "nothing is lost."
DRILL_HEAD = "<tr><th>Broken</th><th>Off after</th><th>At most</th><th></th></tr>"
DRILL_NOT_BROKEN = "not tried"
FACT_RIG_BUILT_IN = "the simulated machine that comes with footscan"
FACT_MACHINE, FACT_RIG, FACT_CAMERA, FACT_ENCODER = "Machine", "Rig file", "Camera", "Encoder"
FACT_OUTPUTS, FACT_CALIBRATION, FACT_DATA = "Outputs", "Calibration", "Data folder"
LOG_EMPTY = "Nothing has happened yet."


# Jobs and notes
WORKING = "Working"
CANCEL = "Cancel"
CANCEL_HINT = "Ends what is being done; what was captured is kept"
CANCELLING = "Cancelling …"
CANCELLED = "{what}: cancelled."
FAILED = "That did not work"
INTERNAL = "Something unexpected happened ({what}). Lasers and motor are off. Start footscan again if it stays."
JOB_CHECK, JOB_SCAN, JOB_MEASURE, JOB_REPROCESS = "Checking", "Scanning", "Measuring", "Measuring again"
JOB_SMOOTH, JOB_CALIBRATE, JOB_EMPTY = "Smoothing", "Computing", "Looking at the bare footboard"
JOB_PLACEMENT, JOB_JUDGE, JOB_CLOSE = (
    "Placement {number}",
    "What would a calibration promise now?",
    "Closing the recording",
)
JOB_DECLARE = "Declaring, and measuring again what it changes"
JOB_CORRECT = "Measuring again"
JOB_BOARD = "Drawing the board"
HOME_FIRST = "connected: Check (Scan tab) lets the head find its home"
JOB_IN_FORCE, JOB_EXAMINE, JOB_DRILL = "Opening the machine again", "Examining", "Drill"

# Last

LAST_FOOT = "Foot to fit"
LAST_PROFILE = "Room for the foot"
LAST_PROFILE_HINT = "therapeutic: the whole seen foot inside; comfort and dress: some pressure is usual"
LAST_RANK = "1  Rank the lasts"
LAST_RANK_HINT = "Compares the foot's measurements with every last of its side"
LAST_CHOSEN = "Last"
LAST_NONE = "(rank the lasts first)"
LAST_COMPARE = "2  Lay it round the foot"
LAST_COMPARE_HINT = "Places the foot in the chosen last and measures the room; needs a moment"
LAST_SHOW = "Show last as"
LAST_SHOW_KINDS = ("Last round the foot", "Clearance map", "Changed areas")
LAST_HIDE, LAST_UNHIDE = "Show the scan again", "Show the last again"
LAST_HIDE_HINT = "What the 3-D view shows; nothing is lost by it"
LAST_FOOT_NONE = "No measured foot yet. Scan one, or choose a patient who has one."
FOOT_NONE = "(no measured foot yet)"
LAST_ROOM = "<b>Room in the last of the library, {name}:</b>"
LAST_MADE, LAST_MADE_HOLDS, LAST_MADE_NOT = (
    "Customised",
    "The last holds the seen foot. Proof, dimensions and files stand below.",
    "The last does not hold the seen foot; below stands what was not met.",
)
LAST_RANKING_HEAD = (
    "<tr><th></th><th>Last</th><th>Score</th><th>Ball length</th><th>Ball girth</th><th>Length</th></tr>"
)
LAST_RANKING_NOTE = "Lower is better. Columns: last less foot, mm. Length: free room in front of the toes, by sticks."
LAST_REGION_HEAD = (
    "<tr><th>Region</th><th>Least</th><th>5 %</th><th>Mean</th><th>95 %</th><th>Tight</th><th>Loose</th></tr>"
)
LAST_REGION_NOTE = (
    "Room in mm of skin that was seen, above the feather edge; negative: the foot stands out. Tight: share of the skin "
    "with less room than asked for. Loose: with much more."
)
LAST_GIRTH_HEAD = "<tr><th>Tape, mm</th><th>Foot</th><th>Last</th><th>Last less foot</th></tr>"
LAST_ALLOWANCES = "Allowances"
LAST_TRANSITION = "Transition (mm)"
LAST_TRANSITION_HINT = "How far a change reaches beyond the skin that asks for it; longer is softer and adds material"
LAST_SMOOTH = "Smooth within (mm)"
LAST_SMOOTH_HINT = (
    "The customised last may move by so much where that makes it fairer; the proof is about the smoothed last"
)
LAST_HOLD = "Take material away"
LAST_HOLD_HINT = "Allowed at heel sides, waist and instep, where the foot has too much room; never at the toes"
LAST_PIN_AT, LAST_PIN_AT_HINT = (
    "Pin at",
    "Where the last gets room of its own, such as over a bunion: the inner ball joint",
)
LAST_PLACES = {
    "metatarsale_tibiale": "inner ball joint", "metatarsale_fibulare": "outer ball joint", "toe_1_tip": "big toe",
    "toe_2_tip": "toe 2", "toe_3_tip": "toe 3", "toe_4_tip": "toe 4", "toe_5_tip": "little toe",
    "instep_point": "instep", "pternion": "back of the heel",
}  # fmt: skip
LAST_PIN_RADIUS = "Pin radius (mm)"
LAST_PIN_EXTRA = "Pin room (mm)"
LAST_PIN_EXTRA_HINT = "Added to the least room there; negative where the last may press"
LAST_PIN_ADD = "Set the pin"
LAST_PIN_ADD_HINT = "A spot allowance, such as for a bunion or a hammer toe"
LAST_PIN_CLEAR = "Take all pins out"
LAST_PINS = "Pins ({count}): {words}"
LAST_PINS_NONE = "No pins."
LAST_CUSTOMISE = "3  Customise"
LAST_CUSTOMISE_HINT = "The smoothest change of the last that holds the foot; a few seconds"
LAST_RESULT = "Customised last"
LAST_RESULT_NONE = "Nothing customised yet."
LAST_HOLDS = '<b style="color:#087030">The last holds the seen foot.</b>'
LAST_HOLDS_NOT = '<b style="color:#b00020">The last does not hold the seen foot.</b>'
LAST_PROOF = (
    "{samples} samples of seen skin against the final mesh; worst lack of room {worst:.2f} mm (allowed 0.05). "
    "Unseen skin decides nothing. A flat scan does not prove the pitched shape."
)
LAST_UNMET = "Not met: {what}"
LAST_DIMENSION_HEAD = "<tr><th>Dimension</th><th>Before</th><th>After</th></tr>"
LAST_FILES = "Take the last away"
LAST_FILE_NAMES = {
    "Solid (mm)": {"STL": "stl", "3DM": "3dm", "STEP": "step"},
    "Papers": {"Sheet (PDF)": "pdf", "DXF": "dxf", "JSON": "json"},
}
LAST_FILE_HINTS = {
    "Solid (mm)": "The real side, with its datum; STL is within 0.02 mm of the surface, 3DM and STEP hold the surface",
    "Papers": "Sheet: sections, dimensions and proof to print. DXF: curves. JSON: all numbers, for programs",
}
LAST_ENGRAVE = "Engrave"
LAST_ENGRAVE_HINT = "Cut into the cone top of STL and 3DM: order, side, size; no patient's name"
LAST_LEGEND = (
    ("#8c0a14", "−6 mm"), ("#fa965a", "−2 mm"), ("#ffffff", "0 mm"), ("#6eb4eb", "3 mm"),
    ("#0f2d78", "10 mm"), ("#969696", "not judged: never seen, or above the last"),
)  # fmt: skip
LAST_LEGEND_CHANGED = (("#b08050", "as the standard last"), ("#d6d6d6", "changed"))
LAST_LEGEND_ROUND = (("#e0a080", "foot as seen"), ("#969696", "foot never seen"), ("#d6c0a4", "the last, see-through"))
JOB_RANK, JOB_FIT, JOB_CUSTOMISE, JOB_EXPORT = "Ranking lasts", "Laying the last", "Customising", "Writing the last"
