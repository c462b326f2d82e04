/** A robot in space, with topics that are made up here. */

import { html, type TemplateResult } from "lit";
import { styled } from "../../elements/base/style-directive.js";
import "../../elements/scene/scene.js";
import type { TopicShape } from "../../generated/api.js";
import type { TopicBytes } from "../../generated/wire.js";
import type { OpenBytes } from "../../topics/byte-topics.js";
import { HubApi } from "../../wire/hub-api.js";
import type { GalleryEntry } from "./entry.js";
import { MADE_CAMERA, MADE_ODOMETRY, MADE_PICTURE, MADE_SCAN } from "./made-up/messages.js";

const topicOf = (topic: string, type: string): TopicShape => ({ topic, type, latched: false, max_rate: 0, problem: "", described: true, right: "view", device: "", rate: 5 });
const TOPICS: readonly TopicShape[] = [topicOf("/odom", "nav_msgs/msg/Odometry"), topicOf("/scan", "sensor_msgs/msg/LaserScan")];

const CAMERA_TOPICS: readonly TopicShape[] = [...TOPICS, topicOf("/camera_info", "sensor_msgs/msg/CameraInfo"), topicOf("/image", "sensor_msgs/msg/Image")];
const MADE: Readonly<Record<string, Uint8Array>> = { "/odom": MADE_ODOMETRY, "/scan": MADE_SCAN, "/camera_info": MADE_CAMERA, "/image": MADE_PICTURE };

const message = (data: Uint8Array): TopicBytes => ({ t: "topic_bytes", number: 1, seq: 1, time_us: 0, publish_us: 0, age_ms: 0, encoding: "ros1", every: 1, data });

/** @param broken its scans are none */
function openMade(broken: boolean): OpenBytes {
  return (_path, heard, { topic }) => {
    const data = MADE[topic] ?? MADE_ODOMETRY;
    const timer = setTimeout(() => {
      heard.onState("open", "");
      heard.onBytes?.(message(broken && topic === "/scan" ? data.subarray(0, 40) : data));
    });
    return {
      close: () => {
        clearTimeout(timer);
      },
    };
  };
}

const openSilent: OpenBytes = () => ({ close: () => undefined });

/** A hub that answers the list of topics, and nothing else. */
function hubWith(answer: () => Promise<Response>): (event: Event) => void {
  const api = new HubApi(answer);
  return (event) => {
    // Nearer than the app's: this element's hub is made up.
    event.stopPropagation();
    (event as Event & { readonly callback: (value: unknown) => void }).callback(api);
  };
}

const answering = (topics: readonly TopicShape[]): ((event: Event) => void) => hubWith(() => Promise.resolve(Response.json({ online: true, topics })));
const WITH_TOPICS = answering(TOPICS);
const WITH_CAMERA = answering(CAMERA_TOPICS);
const WITH_NONE = answering([]);
const FAILING = hubWith(() => Promise.resolve(Response.json({ code: "broken", message: "The hub cannot answer now." }, { status: 500 })));
const WAITING = hubWith(() => new Promise<Response>(() => undefined));

function renderScene(hub: (event: Event) => void, open: OpenBytes, online = true, bare = false): TemplateResult {
  return html`<div ${styled({ "--t-scene-height": "24rem" })} @context-request=${hub}>
    <t-scene site="gallery" .online=${online} .bare=${bare} .openTopic=${open}></t-scene>
  </div>`;
}

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-scene",
    wide: true,
    states: [
      { name: "a scan", show: () => renderScene(WITH_TOPICS, openMade(false)) },
      { name: "a camera, to be switched on", show: () => renderScene(WITH_CAMERA, openMade(false)) },
      { name: "in a tile", show: () => renderScene(WITH_TOPICS, openMade(false), true, true) },
      { name: "nothing came yet", show: () => renderScene(WITH_TOPICS, openSilent) },
      { name: "messages that are none", show: () => renderScene(WITH_TOPICS, openMade(true)) },
      { name: "the gateway is away", show: () => renderScene(WITH_TOPICS, openMade(false), false) },
      { name: "loading", show: () => renderScene(WAITING, openSilent) },
      { name: "no topics", show: () => renderScene(WITH_NONE, openSilent) },
      { name: "no topics, gateway away", show: () => renderScene(WITH_NONE, openSilent, false) },
      { name: "failed", show: () => renderScene(FAILING, openSilent) },
    ],
  },
];
