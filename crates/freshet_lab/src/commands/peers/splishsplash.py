"""SPlisHSPlasH in the benchmark tank, for `freshet_lab peers`; needs the package pySPlisHSPlasH.

Arguments: method, spacing (m), seconds, seconds between frames, file for the frames. Writes a record a frame: time (s),
wall time of the stepping so far (s), steps so far as float64, then the positions as float32, and prints "FRAME time".
"""

import importlib.metadata
import json
import os
import sys
import tempfile
import time

method, d, seconds, interval, path = sys.argv[1], *map(float, sys.argv[2:5]), sys.argv[5]

import numpy as np
import pysplishsplash as sph

print("VERSION", importlib.metadata.version("pysplishsplash"), flush=True)
folder = tempfile.mkdtemp(prefix="freshet_peer_")
# Samples lie on the surface of the mesh: with 0.6 d the block starts at its rest density.
low, high = np.full(3, -0.6 * d), np.array([2.0, 1.5, 1.0]) + 0.6 * d
corners = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
with open(f"{folder}/tank.obj", "w") as mesh:
    mesh.writelines("v %.7f %.7f %.7f\n" % corner for corner in corners)
    mesh.writelines("f %d %d %d\nf %d %d %d\n" % (a, b, c, a, c, e) for a, b, c, e in faces)
configuration = {
    "particleRadius": d / 2,
    "simulationMethod": {"WCSPH": 0, "DFSPH": 4}[method],
    "gravitation": [0, -9.81, 0],
    "timeStepSize": 0.001,
    "cflMethod": 1,
    "cflFactor": 1.0 if method == "DFSPH" else 0.5,
    "cflMinTimeStepSize": 0.0001,
    "cflMaxTimeStepSize": 0.005 if method == "DFSPH" else 0.02 * d,
    "boundaryHandlingMethod": 0,
    "enableZSort": True,
}
# DFSPH as in its scene files; the coded stiffness of WCSPH (50) does not hold the water up.
configuration |= {"DFSPH": {"maxError": 0.05}} if method == "DFSPH" else {"WCSPH": {"stiffness": 50000, "exponent": 7}}
wall_body = {
    "geometryFile": "tank.obj", "translation": [0, 0, 0], "rotationAxis": [1, 0, 0], "rotationAngle": 0,
    "scale": [1, 1, 1], "isDynamic": False, "isWall": True, "mapInvert": True, "samplingMode": 0,
}
material = {
    "id": "Fluid", "density0": 1000, "viscosityMethod": 1, "Standard viscosity": {"viscosity": 0.01},
    "surfaceTensionMethod": 0,
}
# Its blocks begin a diameter inside their lower corner and have a layer less than fits.
block = {"denseMode": 0, "start": [-d / 2] * 3, "end": [1 + d / 2] * 3, "translation": [0, 0, 0], "scale": [1, 1, 1]}
scene = {"Configuration": configuration, "Materials": [material], "RigidBodies": [wall_body], "FluidBlocks": [block]}
with open(f"{folder}/scene.json", "w") as file:
    json.dump(scene, file)

base = sph.Exec.SimulatorBase()
base.init(sceneFile=f"{folder}/scene.json", useCache=False, useGui=False, initialPause=False,
          outputDir=f"{folder}/out", stopAt=-1.0)
base.initSimulation()
simulation, clock = sph.Simulation.getCurrent(), sph.TimeManager.getCurrent()
# Started with the clock past the end it initialises and makes no step: the steps are made and timed below.
base.setValueFloat(base.STOP_AT, 0.5)
clock.setTime(1.0)
base.runSimulation()
clock.setTime(0.0)
base.setValueFloat(base.STOP_AT, -1.0)
fluid = simulation.getFluidModel(0)
count = round(1 / d) ** 3
if fluid.numActiveParticles() != count:
    sys.exit(f"made {fluid.numActiveParticles()} particles instead of {count}")

wall, steps, frame = 0.0, 0, 1
with open(path, "wb") as frames:
    while frame * interval <= seconds + 1e-9:
        left = frame * interval - clock.getTime()
        clock.setTimeStepSize(min(clock.getTimeStepSize(), left))
        start = time.perf_counter()
        base.timeStepNoGUI()
        wall += time.perf_counter() - start
        steps += 1
        if clock.getTime() >= frame * interval - 1e-6:
            np.array([clock.getTime(), wall, steps], dtype=np.float64).tofile(frames)
            np.asarray(fluid.getFieldBuffer("position"))[:count].astype(np.float32).tofile(frames)
            print("FRAME", clock.getTime(), flush=True)
            frame += 1
frames.close()
# Its destructors crash.
os._exit(0)
