import { describe, expect, it } from "vitest";
import { whyNoModel } from "../../src/scene/robot-description.js";

const LINK = '<link name="base_link"/>';
const joint = (parent: string, child: string, more = ""): string =>
  `<joint name="wheel" type="continuous"><parent link="${parent}"/><child link='${child}'/>${more}</joint>`;
const robot = (parts: string): string => `<?xml version="1.0"?>\n<robot name="r">${parts}</robot>`;

describe("a robot's description", () => {
  it.each([
    ["a link", LINK],
    ["two links and a joint between them", `${LINK}<link\n  name='wheel'/>${joint("base_link", "wheel")}`],
    ["a simulator's part with links of its own", `${LINK}<gazebo><parent link="world"/></gazebo>`],
    ["a comment about a link", `${LINK}<!-- <parent link="old"/> -->`],
  ])("with %s can be drawn", (_, parts) => {
    expect(whyNoModel(robot(parts))).toBeNull();
  });

  it.each([
    ["without links", robot(""), "the robot's model has no links, so there is nothing to draw"],
    ["with joints only", robot(joint("a", "b")), "the robot's model has no links, so there is nothing to draw"],
    ["whose links are in a comment", robot(`<!-- ${LINK} -->`), "the robot's model has no links, so there is nothing to draw"],
    ["with a joint at no link", robot(LINK + joint("base_link", "wheel")), "the robot's model has a joint at the link wheel, which it does not have"],
    [
      "with a joint that follows none",
      robot(`${LINK}<link name="wheel"/>${joint("base_link", "wheel", '<mimic joint="other"/>')}`),
      "a joint of the robot's model follows the joint other, which it does not have",
    ],
    ["that is another text", "hello", "the robot's description is no URDF"],
    ["that has no end", `<robot>${" ".repeat(4 * 1024 * 1024)}`, "the robot's description is too long"],
  ])("%s is told in words", (_, text, why) => {
    expect(whyNoModel(text)).toBe(why);
  });
});
