// roslibjs at work: topics in each compression, services, driving. Each line is JSON.
import { Ros, Service, Topic } from "roslib";

const ros = new Ros({ url: process.argv[2] });
const tell = (message) => console.log(JSON.stringify(message));
const seconds = (message) => message.header.stamp.sec + message.header.stamp.nanosec / 1e9;

ros.on("error", (error) => {
  console.error(error);
  process.exit(1);
});
ros.on("status", (status) => tell({ status: status.msg }));
await new Promise((connected) => ros.on("connection", connected));

/** The first messages of a topic. */
function messages(name, type, count, options = {}) {
  return new Promise((done) => {
    const topic = new Topic({ ros, name, messageType: type, ...options });
    const got = [];
    topic.subscribe((message) => {
      got.push(message);
      if (got.length === count) {
        topic.unsubscribe();
        done(got);
      }
    });
  });
}

function call(name, type, request) {
  const service = new Service({ ros, name, serviceType: type });
  return new Promise((done) =>
    service.callService(
      request,
      (values) => done({ result: true, values }),
      (words) => done({ result: false, words }),
    ),
  );
}

const ask = (method, ...rest) => new Promise((done, failed) => ros[method](...rest, done, failed));

tell({ topics: await ask("getTopics") });
tell({ scans: await ask("getTopicsForType", "sensor_msgs/LaserScan") });
tell({ services: await ask("getServices"), nodes: await ask("getNodes") });
const details = await ask("getMessageDetails", "geometry_msgs/msg/TwistStamped");
tell({ twist: ros.decodeTypeDefs(details) });

tell({ scan: (await messages("/scan", "sensor_msgs/LaserScan", 1))[0] });
for (const compression of ["none", "cbor", "png"]) {
  const [odom] = await messages("/odom", "nav_msgs/msg/Odometry", 1, { compression });
  const covariance = Array.from(odom.pose.covariance);
  tell({ compression, kind: odom.pose.covariance.constructor.name, covariance, frame: odom.header.frame_id });
}
const image = { compression: "cbor" };
const [picture] = await messages("/camera/image/compressed", "sensor_msgs/CompressedImage", 1, image);
tell({ picture: Array.from(picture.data.subarray(0, 2)), format: picture.format });
for (const compression of ["none", "cbor"]) {
  const [map] = await messages("/map", "nav_msgs/OccupancyGrid", 1, { compression });
  tell({ map: map.info, cells: map.data.length, occupied: Array.from(map.data).filter((one) => one > 50).length });
}
const slow = { throttle_rate: 200, queue_length: 10 };
const throttled = (await messages("/odom", "nav_msgs/Odometry", 5, slow)).map(seconds);
tell({ throttled: throttled.slice(1).map((one, place) => one - throttled[place]) });

tell({ scatter: await call("/reinitialize_global_localization", "std_srvs/Empty", {}) });
const pose = { header: { frame_id: "map" }, pose: { pose: { position: { x: 50, y: 0, z: 0 } } } };
tell({ offMap: await call("/set_initial_pose", "nav2_msgs/SetInitialPose", { pose }) });
tell({ noService: await call("/fly", "std_srvs/Empty", {}) });

const wheels = new Topic({ ros, name: "/cmd_vel", messageType: "geometry_msgs/TwistStamped" });
const odometry = new Topic({ ros, name: "/odom", messageType: "nav_msgs/Odometry", queue_length: 100 });
let driven;
odometry.subscribe((message) => {
  const v = message.twist.twist.linear.x;
  if (driven === undefined && v < 0.05) {
    wheels.publish({ header: { frame_id: "" }, twist: { linear: { x: 0.1, y: 0, z: 0 } } });
  } else if (driven === undefined) {
    driven = seconds(message);
  } else if (v === 0) {
    tell({ stoppedAfter: seconds(message) - driven });
    ros.close();
  }
});
