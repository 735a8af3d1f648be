"""Make the answers anew whose pages are looked at every day: `python -m tests.browser.make_answers`.

After a change of what an answer holds; each is what `answer.json` has in the folder of the command.
"""

import shutil
import tempfile
from pathlib import Path

from desim_warehouse.folders import ANSWER
from tests.browser.test_axe import KEPT_ANSWERS, an_answer_of_plan, an_answer_of_why

if __name__ == "__main__":
    for name, make in (("plan", an_answer_of_plan), ("why", an_answer_of_why)):
        with tempfile.TemporaryDirectory() as folder:
            make(Path(folder))
            shutil.copy(Path(folder) / ANSWER, KEPT_ANSWERS / f"{name}.json")
