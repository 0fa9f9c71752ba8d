"""From samples in arrays to their vibration, an actuator's motion, and a table of a sweep."""
import haptometer as hm
import numpy as np

RATE_HZ = 10e3

# three seconds of 225 Hz with 0.1 um of noise
time_s = np.arange(int(3 * RATE_HZ)) / RATE_HZ
displacement_m = 50e-6 * np.sin(2 * np.pi * 225 * time_s) + np.random.default_rng(1).normal(0, 1e-7, time_s.size)

trial = hm.Trial.from_arrays(displacement_m, rate=RATE_HZ, labels={"subject": "3"})
analysis = hm.analyze(trial, band=(20, 500))
if analysis.rms is None:
    print("not answered:", *analysis.reasons, sep="\n  ")
else:
    print("vibration", analysis.rms, "95 %:", analysis.rms.interval)

filtered_m = hm.bandpass(displacement_m, rate=RATE_HZ, band=(20, 500))
print("filtered RMS", float(np.std(filtered_m)), "m")

tone = hm.sine_fit(displacement_m, rate=RATE_HZ)
if tone is not None:
    print("tone", tone.frequency, tone.amplitude)
