-- Links between pages lead to their HTML; links to other files of the source code, which are not beside it, become text.
function Link(link)
  local path, place = link.target:match("^([^#]*)(#?.*)$")
  if path == "" or path:match("^%a+:") then return nil end
  if not path:match("%.md$") and not path:match("/$") then return link.content end
  link.target = path:gsub("/$", "/README.md"):gsub("README%.md$", "index.md"):gsub("%.md$", ".html") .. place
  return link
end
