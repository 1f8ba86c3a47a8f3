"""The page in the browser: operator, clinician and technician drive everything from here.

| file | what |
|---|---|
| `texts` | every word on the page |
| `door`, `gate`, `keys` | who may come in, which values are believed, who controls |
| `state`, `desk`, `binding` | the state in one place; the thread that alone changes it; from handles to commands |
| `station` | the open machine and the records |
| `visit`, `visit_scan`, `visit_result`, `visit_calibrate` | what people do, step by step |
| `placement`, `adjust_light` | small programs for the machine: where the foot stands, light while a button is held |
| `live_picture`, `view_foot`, `inspected`, `measurement_tables` | what is drawn and written |
| `heartbeat`, `logbook` | the watch over the browser; what happened |
| `page`, `panel_*`, `tab_*` | the frame; one file per part of it (`tab`: what a tab is) |
| `serve`, `readiness`, `self_check` | from start to end; what is loaded later; whether it stands |
| `headless`, `visitor`, `screenshots`, `page_bench` | a browser without a window: checks, pictures, timings |
"""
