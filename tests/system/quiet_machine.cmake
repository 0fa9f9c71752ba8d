# The cases of system_test that need the machine for themselves: streams that must not lose a line.
# Read by ctest, which alone knows the cases.
set_tests_properties(
  system.BeforeRecording.AFastStreamIsReadyForTheBand
  system.BeforeRecording.LookingKeepsNothingAndShowsTheBand
  system.MainJob.AStreamedTrialGivesTheScenesRmsAndFrequency
  PROPERTIES RUN_SERIAL TRUE)
