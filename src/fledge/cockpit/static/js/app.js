// The cockpit's page: everything is made here, once, and told of each other.

import { startBanner } from "./banner.js";
import { startCommand } from "./command.js";
import { Demonstrate } from "./demonstrate.js";
import { Fly } from "./fly.js";
import { Gamepads } from "./gamepad.js";
import { startInstruments } from "./instruments.js";
import { Keyboard } from "./keyboard.js";
import { startLaunch } from "./launch.js";
import { Link } from "./link.js";
import { notice } from "./notices.js";
import { Orders } from "./orders.js";
import { startPadDialog } from "./pad-dialog.js";
import { $ } from "./page.js";
import { Route } from "./route.js";
import { startSeat } from "./seat.js";
import { startSituation } from "./situation.js";
import { Stage } from "./stage.js";
import { Sticks } from "./sticks.js";
import { Tape } from "./tape.js";
import { startTheme } from "./theme.js";
import { TouchSticks } from "./touch.js";
import { Train } from "./train.js";
import { Watch } from "./watch.js";

const link = new Link(`${location.protocol.replace("http", "ws")}//${location.host}/ws`);
const route = new Route();
const orders = new Orders();
const isCockpit = () => ["fly", "demonstrate"].includes(route.view);

const commands = {
  KeyG: () => sticks.arm(),
  KeyP: () => $("pause").click(),
};
for (let vehicle = 0; vehicle < 10; vehicle += 1) {
  commands[`Digit${vehicle}`] = () => $("vehicles").children[vehicle]?.click();
}
const keyboard = new Keyboard(orders, isCockpit, commands);
const touch = new TouchSticks($("pad-left"), $("pad-right"));
const pads = new Gamepads(orders, () => sticks.arm());
const sticks = new Sticks(link, orders, [
  (seconds) => keyboard.read(seconds),
  () => touch.read(),
  () => pads.read(isCockpit() && !$("pad-dialog").open),
]);

const stage = new Stage(link);
startSituation(link, sticks);
const fly = new Fly(link);
new Demonstrate(link, sticks, route, new Tape(link));
const watch = new Watch(route);
const train = new Train(link, (policy) => {
  route.go("fly");
  fly.start(policy);
});
startSeat(link);
startLaunch(link);
startCommand(link, sticks, orders);
startInstruments(link, stage, sticks);
startBanner(link, stage, sticks, pads);
startPadDialog(pads);
startTheme($("theme"), () => [stage, watch, train].forEach((one) => one.redraw()));
link.on("notice", ({ text, level }) => notice(text, level));
link.on("stored", () => watch.refresh());
route.onChange(() => orders.letGo());
$("keys").addEventListener("click", () => $("keys-dialog").showModal());
setInterval(() => touch.show(sticks), 1_000 / 30);
route.start();
link.connect();
