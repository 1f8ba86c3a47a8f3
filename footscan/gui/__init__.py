"""The page in the browser: operator, clinician and technician drive everything from here.

| file | what |
|---|---|
| `texts` | every word on the page |
| `door`, `gate`, `keys` | who may come in, which values are believed, who controls |
| `state`, `desk` | the state in one place; the thread that alone changes it |
| `station`, `adjust_light` | the open machine and the records |
| `visit`, `visit_scan`, `visit_result` | what the operator does, step by step |
| `live_picture`, `live_view`, `heartbeat` | pictures as they come; the watch over the browser |
| `page` | the frame; one file `tab_*` or `panel_*` per part of it |
| `serve` | from start to end |
"""
