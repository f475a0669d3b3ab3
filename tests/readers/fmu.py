"""FMPy on both units: validation, simulation with the packed binary, compilation from the packed sources, state saved and restored.

Arguments: the folder with the units with binaries, the folder with those of sources only. Standard input: JSON with `step_s`, and `torque_nm`, `gear`,
one of each per step. Prints JSON: per unit the problems of the validation and the speeds after every step, by the binary and by the sources.
"""

import json
import os
import shutil
import sys
import sysconfig

import numpy as np
from fmpy import extract, read_model_description, simulate_fmu, supported_platforms
from fmpy.build import build_platform_binary
from fmpy.simulation import instantiate_fmu
from fmpy.validation import validate_fmu

packed, sources = sys.argv[1:3]
# FMPy builds with cmake, which is a package beside it; what that prints is no answer
os.environ["PATH"] = sysconfig.get_path("scripts") + os.pathsep + os.environ["PATH"]
task = json.load(sys.stdin)
step_s, torque, gear = task["step_s"], task["torque_nm"], task["gear"]
count = len(torque)


def simulated(path, start_values):
    signals = np.array(
        [(k * step_s, torque[k], gear[k]) for k in range(count)],
        dtype=[("time", np.float64), ("torque_nm", np.float64), ("gear", np.int32)],
    )
    result = simulate_fmu(
        path,
        validate=True,
        stop_time=count * step_s,
        step_size=step_s,
        output_interval=step_s,
        input=signals,
        output=["speed_mps", "speed_reading_mps"],
        start_values=start_values,
        fmi_type="CoSimulation",
    )
    return [[float(row["speed_mps"]), float(row["speed_reading_mps"])] for row in result][1:]


def restored(path):
    """Speeds after a state was saved, driven on from, and restored: twice the same."""
    description = read_model_description(path)
    references = {v.name: v.valueReference for v in description.modelVariables}
    folder = extract(path)
    unit = instantiate_fmu(folder, description, fmi_type="CoSimulation")
    two = description.fmiVersion == "2.0"
    if two:
        unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    put, get = (unit.setReal, unit.getReal) if two else (unit.setFloat64, unit.getFloat64)
    put([references["torque_nm"]], [24.0])

    def drive(from_step, steps):
        for k in range(from_step, from_step + steps):
            unit.doStep(currentCommunicationPoint=k * step_s, communicationStepSize=step_s)
        return get([references["speed_mps"]])[0]

    drive(0, 300)
    state = unit.getFMUState()
    stored = unit.serializeFMUState(state)
    first = drive(300, 300)
    unit.setFMUState(state)
    second = drive(300, 300)
    again = unit.deserializeFMUState(stored)
    unit.setFMUState(again)
    third = drive(300, 300)
    unit.terminate()
    unit.freeInstance()
    shutil.rmtree(folder, ignore_errors=True)
    return [first, second, third]


answer = {}
for name in ("plant_fmi2.fmu", "plant_fmi3.fmu"):
    path = os.path.join(packed, name)
    alone = os.path.join(sources, name)
    before = supported_platforms(alone)
    built = extract(alone)
    build_platform_binary(built)
    answer[name] = {
        "problems": validate_fmu(path) + validate_fmu(alone),
        "platforms": supported_platforms(path),
        "platforms_of_sources": before,
        "binary": simulated(path, {}),
        "compiled": simulated(built, {}),
        "heavy": simulated(path, {"inertia_factor": 1.3, "friction_factor": 0.8, "lag_factor": 1.5, "dead_time_factor": 1.2}),
        "noisy": simulated(path, {"noise_factor": 1.0, "seed": 7}),
        "restored": restored(path),
    }
print(json.dumps(answer))
