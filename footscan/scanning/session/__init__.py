"""The scan session: who owns the machine, what it does next, and where its frames go.

| file | what |
|---|---|
| `states`, `plan`, `timeline` | what the machine is doing, what a scan will be, what shone when |
| `grabber` | the thread that stamps frames and never waits for anybody |
| `keeper`, `picker` | the thread that writes the recording; frames picked by angle |
| `live` | the thread that makes points for the screen |
| `machine`, `programs`, `checks` | the head's doings, step by step; the check before a scan |
| `control` | the control thread, which owns the rig |
"""
