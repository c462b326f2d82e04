/** Whether the text of a robot's description can be drawn, said in words. Without a browser. */

import { msg, str } from "@lit/localize";

/** Letters of a description; it is parsed at once. */
const MOST_LETTERS = 4 * 1024 * 1024;

/** Comments, and what is for a simulator: a model is made of neither. */
const ASIDE = /<!--[\s\S]*?-->|<gazebo[\s>][\s\S]*?<\/gazebo>/g;

/** Says why no model can be made of a text; null where one can. */
export function whyNoModel(urdf: string): string | null {
  if (urdf.length > MOST_LETTERS) return msg("the robot's description is too long");
  if (!/<robot[\s>]/.test(urdf)) return msg("the robot's description is no URDF");
  const text = urdf.replace(ASIDE, "");
  const links = namesIn(text, /<link\s[^>]*?\bname\s*=\s*["']([^"']*)["']/g);
  if (links.size === 0) return msg("the robot's model has no links, so there is nothing to draw");
  // A part that hangs on nothing ends the parser with a sentence about itself.
  for (const name of namesIn(text, /<(?:parent|child)\s[^>]*?\blink\s*=\s*["']([^"']*)["']/g)) {
    if (!links.has(name)) return msg(str`the robot's model has a joint at the link ${name}, which it does not have`);
  }
  const joints = namesIn(text, /<joint\s[^>]*?\bname\s*=\s*["']([^"']*)["']/g);
  for (const name of namesIn(text, /<mimic\s[^>]*?\bjoint\s*=\s*["']([^"']*)["']/g)) {
    if (!joints.has(name)) return msg(str`a joint of the robot's model follows the joint ${name}, which it does not have`);
  }
  return null;
}

function namesIn(text: string, pattern: RegExp): Set<string> {
  return new Set([...text.matchAll(pattern)].map((found) => found[1] ?? ""));
}
