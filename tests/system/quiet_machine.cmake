# Tests that need the machine for themselves: streams that must not lose a line, processes that are
# timed or killed at a moment. Read by ctest when all tests are known.
set_tests_properties(
  system.daemon_reconnects_after_emulator
  system.daemon_reconnects_after_end
  system.daemon_reconnects_after_reset
  system.daemon_reconnects_after_terminal
  system.kill_nine
  system.peer_polls_the_emulator
  system.BeforeRecording.AFastStreamIsReadyForTheBand
  system.BeforeRecording.LookingKeepsNothingAndShowsTheBand
  system.MainJob.AStreamedTrialGivesTheScenesRmsAndFrequency
  PROPERTIES RUN_SERIAL TRUE)
