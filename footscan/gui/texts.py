"""Every word on the page, in one place, so that it can be put into another language."""

TITLE = "footscan"

TAB_PATIENT, TAB_SCAN, TAB_INSPECT, TAB_CALIBRATE, TAB_SYSTEM = "Patient", "Scan", "Inspect", "Calibrate", "System"

# Frame
STOP = "STOP"
STOP_HINT = "Lasers and motor off, now; what was captured is kept. It is no emergency stop. Key: X"
STOP_HOTKEY_LABEL = "Stop lasers and motor"
STOPPED_BY = "stopped on the page"
LASER_ON = "LASER ON: {lasers}"
ARMED = "ARMED"
RESET = "I have looked: reset"
RESET_HINT = "After a fault or an emergency stop, once the machine was looked at"
NO_CALIBRATION = "NO CALIBRATION"
CALIBRATION_AGE = "calibrated {days} days ago"
CALIBRATION_OLD = "CALIBRATION OLD ({days} days)"
CALIBRATION_UNDATED = "simulated calibration"
DISK_FREE = "{gigabytes:.0f} GB free"
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
TAKE_OVER_BUSY = "The machine is busy; control stays where it is until it has ended."
GIVE, KEEP = "Give control", "Keep control"
REFUSED_VALUE = "This value is not allowed and was not taken."
ONLY_WATCHING = "You only watch. Ask for control first."

# Camera
CAMERA = "Camera"
PICTURE = "Picture"
KINDS = ("Grey", "Binary", "Stripe", "Overlay")
THRESHOLD = "Threshold"
THRESHOLD_HINT = "Grey value above which a pixel counts as laser light"
AUTOMATIC = "Automatic threshold"
AUTOMATIC_HINT = "One threshold per scan, found where the tail of the background ends"
AUTOMATIC_VALUE = "automatic: <b>{value}</b> &nbsp; in use: <b>{used}</b> &nbsp; {points} stripe points"
ROW = "Row"
ROW_HINT = "The row of the picture whose brightness is drawn"
EXPOSURE = "Exposure and profile"
EXPOSURE_TITLE = "Brightness of all pixels (log10 of count)"
PROFILE_TITLE = "Brightness along the row"
SHINE = "Hold for laser light"
SHINE_HINT = "Hold the button down: the laser shines as long as you hold it. Arm first."
SHINE_LASER = "Laser"
LASERS = ("Right", "Left")
FLICKER = "No picture yet."

# Patient
OPERATOR = "Operator"
OPERATOR_HINT = "Your name; it is kept with every scan"
FIND = "Find patient"
FIND_HINT = "Part of the name, the own number or the birth date; accents do not matter"
FOUND = "Found"
NOBODY_FOUND = "(nobody; enter a new patient below)"
CHOOSE = "Take this patient"
NEW_PATIENT = "New patient"
NAME, BORN, NUMBER, NOTES = "Name", "Born", "Own number", "Notes"
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

# Scan
FOR_PATIENT = "Scan for <b>{name}</b>"
NEXT_FOOT = "Next: the {side} foot."
BOTH_DONE = "Both feet are accepted. Repeat one, or take the next patient."
NO_PATIENT_SCAN = "Choose a patient in the Patient tab first."
SIDE, LOAD, SURFACE, PROFILE = "Foot", "Load", "Skin", "Density"
SIDE_HINT = "Which foot stands on the board"
LOAD_HINT = "How the person stands or sits"
SURFACE_HINT = "What covers the skin"
PROFILE_HINT = "How densely the foot is scanned"
LOADS = {"unknown": "not said", "unloaded": "unloaded", "seated": "seated", "bipedal": "standing on both feet",
         "single_leg": "standing on this leg"}  # fmt: skip
SURFACES = {"unknown": "not said", "bare": "bare", "sock": "sock", "bandage": "bandage", "dressing": "dressing"}
SIDES = {"left": "left", "right": "right"}
CHECK, START = "1  Check", "2  Start"
CHECK_HINT = "Homes the head, tries lasers and motor, looks where the foot stands"
START_HINT = "Countdown, then the scan"
CHECK_FIRST = "Check first."
CHECK_GOOD = "Checked: nothing stands in the way. Start when the person stands still."
CHECK_REMARKS = "Checked, with remarks:"
CHECK_BAD = "Cannot scan yet:"
ARM_TITLE = "Look at the person first"
ARM_QUESTION = "Is nobody's face at beam height, and may the lasers and the motor be switched on?"
ARM_YES, ARM_NO = "Yes, nobody's face is there", "No"
STAND_STILL = "STAND STILL: {seconds:.0f}"
REMAINING = "{percent:.0f} % - {seconds:.0f} s to go - {points} points"
PROCESSING = "Measuring the foot: {done} of {total} pictures"
SCAN_STOPPED = "Scan stopped"
SCAN_KEPT = "{why} What was captured lies in {folder}. Next: check again, then start again."
BUSY = "The machine is busy. Wait, or press STOP."
PLACEMENT_HINT = "Toes towards the camera (arrow), middle of the foot on the cross."

# Result
RESULT_NONE = "No result yet."
RESULT_OF = "{side} foot, take {number}"
ACCEPT, REMARK, REPEAT, REPROCESS = "Accept", "Use with remark", "Repeat", "Measure again"
ACCEPT_HINT = "Mark this take as the one to work with"
REMARK_HINT = "Use it all the same; your remark is kept with your name"
REPEAT_HINT = "The take is kept but not used; scan this foot again"
REPROCESS_HINT = "With the threshold on the left, without the patient; the earlier result is kept"
REMARK_LABEL = "Remark"
REMARK_NEEDED = "Type a remark first: it says why."
AGREEMENT = "Lasers agree within {median:.2f} mm (zone {zone}, the largest)"
COVERAGE = "Skin seen {seen:.0%}, bridged {bridged:.0%}, assumed {assumed:.0%}"
REFUSED_FOOT = "No foot could be measured: {why}"
ACCEPTED, REMARKED, REPEATED = "Accepted", "Kept with your remark", "Marked to be repeated"
VERDICTS = {"undecided": "undecided", "accepted": "accepted", "with_remark": "with remark", "repeat": "repeat"}

# Inspect
INSPECT_NONE = "No foot to look at yet. Choose a patient with a scan, or scan one."
TAKE = "Take"
SHOW = "Show"
SHOW_KINDS = ("Shaded", "Seen / assumed", "Distance to points")
OTHER_FOOT = "Other foot beside it"
SECTION = "Section"
SECTION_SHARE = "Place (% of length)"
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
SMOOTHING = "Filter and smooth"
FILTER = "Filter points"
FILTER_HINT = "0 off, 1 full; works on a copy"
SMOOTH = "Smooth over (mm)"
SMOOTH_HINT = "0 off; features of this size lose half their height; works on a copy"
SMOOTH_GO = "Try it"
DOWNLOADS = "Downloads"
DOWNLOAD_NAMES = {"STL": "surface.stl", "PLY": "surface.ply", "JSON": "measurements.json", "CSV": "sections.csv",
                  "Picture": "report.png"}  # fmt: skip
MEASURE_HEAD = "<tr><th>What</th><th>Value</th><th>Interval</th><th></th></tr>"
LEGEND_ORIGIN = (
    '<span style="color:#e0a080">■</span> seen &nbsp; <span style="color:#e8c020">■</span> bridged '
    '&nbsp; <span style="color:#8090a0">■</span> assumed'
)
LEGEND_RESIDUAL = (
    '<span style="color:#2060ff">■</span> 0 mm &nbsp; <span style="color:#30c060">■</span> 0.2 mm &nbsp; '
    '<span style="color:#ff3020">■</span> 0.4 mm or more &nbsp; <span style="color:#8090a0">■</span> not seen'
)

# Calibrate
CALIBRATE_INTRO = "Recordings of the calibration board in <code>{folder}</code>:"
CALIBRATE_NONE = "(no calibration recording there)"
CALIBRATE_RECORDING = "Recording"
CALIBRATE_GO = "Calibrate"
CALIBRATE_HINT = "Computes a new calibration; the one in force stays until you accept the new one"
CALIBRATE_MAKE = "Make one with the simulated machine"
CALIBRATE_MAKE_HINT = "The simulated machine photographs its board; takes a minute or two"
CALIBRATE_ACCEPT, CALIBRATE_KEEP = "Put the new one in force", "Keep the old one"
CALIBRATE_RESULT = "New calibration, not in force yet:"
CALIBRATE_DONE = "The new calibration is in force for scans from the next start of footscan."
CALIBRATE_KEPT = "The old calibration stays in force."

# System
DEVICES = "Devices"
LOG = "Log"
LOG_EMPTY = "Nothing has happened yet."


# Jobs and notes
WORKING = "Working"
CANCEL = "Cancel"
FAILED = "That did not work"
INTERNAL = "Something unexpected happened ({what}). Lasers and motor are off. Start footscan again if it stays."
DONE = "Done"
JOB_CHECK, JOB_SCAN, JOB_MEASURE, JOB_REPROCESS = "Checking", "Scanning", "Measuring", "Measuring again"
JOB_SMOOTH, JOB_CALIBRATE, JOB_BOARD = "Smoothing", "Calibrating", "Photographing the board"

GLOSSARY = {
    "foot_length": "From the pternion, the hindmost point of the heel, to the tip of the longest toe, along the axis",
    "ball_girth": "Tape around both heads of the metatarsals",
    "instep_girth": "Tape around the middle of the foot, over the instep",
    "foot_breadth": "Across the heads of the first and fifth metatarsal",
    "heel_breadth": "Across the widest part of the heel",
    "instep_height": "From the board to the top of the instep",
}
