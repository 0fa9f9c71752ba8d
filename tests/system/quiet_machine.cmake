# The cases of system_test that need the machine for themselves: streams that must not lose a line,
# and devices whose answers acquire has little patience with.
# Read by ctest, which alone knows the cases.
set_tests_properties(
  system.BeforeRecording.AFastStreamIsReadyForTheBand
  system.BeforeRecording.LookingKeepsNothingAndShowsTheBand
  system.LineSensors.ADlEn1IsRecordedOverTcp
  system.LineSensors.ADlRs1aWithTwoAmplifiersIsSetZeroedAndRecorded
  system.LineSensors.AnLkgIsRecordedOverATerminal
  system.LineSensors.LateAnswersAreNotTakenForOthersByTheRunningProgram
  system.MainJob.AStreamedTrialGivesTheScenesRmsAndFrequency
  PROPERTIES RUN_SERIAL TRUE)
