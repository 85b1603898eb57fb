"""Clock, runner, safe stop, record, replay, mocks and report of a run."""
