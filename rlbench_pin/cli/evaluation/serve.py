"""`rlbench-pin serve POLICY`: a policy for evaluations in other environments, or on other machines."""

from __future__ import annotations

import os
import sys

from rlbench_pin.cli.arguments.evaluation import serve as arguments
from rlbench_pin.errors import TaskEnvironmentError
from rlbench_pin.evaluation.policies.policy_process import answers_for
from rlbench_pin.evaluation.policies.policy_server import listen, serve_answers
from rlbench_pin.evaluation.policies.references import find_policy


class Serve(arguments.Serve):
    """The work of `rlbench-pin serve`."""

    def run(self) -> int:
        """Serve until Ctrl-C."""
        if not self.policy:
            raise TaskEnvironmentError("No policy was named. Use `rlbench-pin serve POLICY`, for example `my_policy.py:make`.")
        found = find_policy(self.policy)
        if found.place == "socket":
            raise TaskEnvironmentError(f"'{self.policy}' is served already. Name what answers there.")
        try:
            listener = listen(self.address, self.anywhere)
        except (ValueError, OSError) as error:
            hint = "" if isinstance(error, ValueError) else " Is it in use? Choose another `--address`."
            said = str(error).replace("or allow it", "or pass `--anywhere`")
            raise TaskEnvironmentError(f"'{self.address}' cannot be listened at: {said.rstrip('.')}.{hint}") from error
        sys.path.insert(0, os.getcwd())  # where `module:factory` is looked for, as with `python -m`
        print(f"{self.policy} is served at {self.address}; Ctrl-C ends it", flush=True)
        serve_answers(lambda: answers_for(found.target), listener)
        return 0
