"""A controller for `pivot-cal verify --controller 'python3 examples/controller.py'`: torque from a guessed inertia and friction."""

import json
import math
import sys

FRICTION_NM, INERTIA_NM_PER_MPS2, GAIN_PER_S = 10.0, 22.0, 3.0
number, phase, begun_rad, planned_mps, wheel_deg, failure = 0, "idle", 0.0, 0.0, 0.0, None
for line in sys.stdin:
    seen = json.loads(line)
    if "start" in seen:  # the first line of a run; it needs no answer
        start = seen["start"]
        continue
    turn, torque_nm, gear = seen["turn"], 0.0, None
    if turn and turn["number"] != number:
        number, phase, begun_rad, planned_mps = turn["number"], "waiting_for_angle", seen["heading_rad"], start["start_speed_mps"]
        wheel_deg = turn["wheel_angle_deg"]
    if turn:
        gear, sign = turn["gear"], 1.0 if turn["gear"] == "forward" else -1.0
        left_rad = math.radians(abs(turn["turn_deg"])) - abs(seen["heading_rad"] - begun_rad)
        left_m = left_rad * start["wheelbase_m"] / abs(math.sin(math.radians(turn["wheel_angle_deg"])))
        speed_mps = sign * (seen["speed_mps"] or 0.0)
        is_there = abs(seen["wheel_angle_deg"] - wheel_deg) < 1.5
        if seen["emergency_stop"] and phase not in ("succeeded", "failed"):
            phase, failure = "failed", "obstacle_stop"
        elif phase == "waiting_for_angle" and is_there and seen["gear"] == gear:
            phase = "driving"
        elif phase == "driving" and left_m < 0.015:
            phase = "waiting_for_standstill"
        elif phase == "waiting_for_standstill" and abs(speed_mps) < 0.02:
            phase, wheel_deg = "restoring_angle", turn["return_wheel_angle_deg"]
        elif phase == "restoring_angle" and is_there:
            phase = "succeeded"
        if phase == "driving":
            planned_mps = min(planned_mps + start["accel_mps2"] * start["period_s"], start["cruise_speed_mps"])
            target_mps = min(planned_mps, math.sqrt(max(2.0 * start["decel_mps2"] * left_m, 0.0)))
            accel_mps2 = max(-0.5, min(0.5, GAIN_PER_S * (target_mps - speed_mps)))
            torque_nm = sign * (FRICTION_NM + INERTIA_NM_PER_MPS2 * accel_mps2)
    answer = {"torque_nm": torque_nm, "wheel_angle_deg": wheel_deg, "gear": gear or "neutral", "phase": phase, "failure": failure}
    print(json.dumps(answer), flush=True)
