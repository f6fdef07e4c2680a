"""The engine ``bullet``; ``sim/bullet.py`` has its world."""

from sim.engines import PhysicsEngine

ENGINES = (
    PhysicsEngine(
        name="bullet",
        package="pybullet",
        module="pybullet",
        maker="sim.bullet:BulletWorld",
        loader="sim.bullet:load_pybullet",
    ),
)
