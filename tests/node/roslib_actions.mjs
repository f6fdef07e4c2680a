// roslibjs sends goals: reached, canceled, replaced, refused. Each line is JSON.
import { Action, Ros } from "roslib";

const ros = new Ros({ url: process.argv[2] });
const tell = (message) => console.log(JSON.stringify(message));
ros.on("error", (error) => {
  console.error(error);
  process.exit(1);
});
await new Promise((connected) => ros.on("connection", connected));
const action = new Action({ ros, name: "/navigate_to_pose", actionType: "nav2_msgs/action/NavigateToPose" });

/** Send a goal; `driving` is called with its id at its first feedback. */
function go(x, y, driving = () => {}) {
  let feedback = 0;
  return new Promise((done) => {
    const pose = { header: { frame_id: "map" }, pose: { position: { x, y }, orientation: { w: 1 } } };
    const id = action.sendGoal(
      { pose },
      (values) => done({ result: true, values, feedback }),
      (one) => {
        feedback += 1;
        if (feedback === 1) driving(id, one);
      },
      (words) => done({ result: false, words, feedback }),
    );
  });
}

tell({ reached: await go(0.12, 0.0) });
tell({ canceled: await go(-0.3, 0.25, (id) => action.cancelGoal(id)) });
let second;
const first = await go(-0.3, 0.25, () => (second = go(0.3, 0.25, (id) => action.cancelGoal(id))));
tell({ replaced: first, second: await second });
tell({ refused: await go(0.5, 0.0) });
process.exit(0);
